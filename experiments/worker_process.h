#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "experiments/line_pipe.h"
#include "experiments/worker_protocol.h"

namespace binpick {

/// How a process ended.
struct ProcessEnd {
  std::string text;           ///< "signal 6 (SIGABRT)" or "exit code 1"
  bool from_outside = false;  ///< by a signal that others send: SIGKILL, SIGTERM, SIGINT, SIGHUP
};

/// A child process that runs this very executable as `worker`. It dies with its parent: the kernel
/// kills it, and its orders end.
class WorkerProcess {
 public:
  /// @throws IoError when no process can be started.
  WorkerProcess();
  WorkerProcess(WorkerProcess&&) = default;
  /// Kills the process if it still runs, and collects it.
  ~WorkerProcess();

  /// @return false when the worker is gone.
  bool send(const WorkerOrder& order);
  /// Replies that have arrived. @return false when the worker closed its end.
  bool receive() { return replies_.fill(); }
  [[nodiscard]] std::optional<std::string> next_reply() { return replies_.next(); }
  /// Log lines that have arrived (its stdout and stderr).
  bool receive_log() { return log_.fill(); }
  [[nodiscard]] std::optional<std::string> next_log() { return log_.next(); }

  [[nodiscard]] int reply_descriptor() const noexcept { return replies_.descriptor(); }
  [[nodiscard]] int log_descriptor() const noexcept { return log_.descriptor(); }

  /// Processor time of all its threads so far, s.
  [[nodiscard]] double processor_time() const noexcept;
  void kill() noexcept;
  /// Waits for the end.
  [[nodiscard]] ProcessEnd wait();

 private:
  struct Pid {
    Pid() = default;
    Pid(Pid&& other) noexcept : value(other.value) { other.value = -1; }
    pid_t value = -1;
  };
  Pid pid_;
  FileDescriptor orders_;
  LineReader replies_{FileDescriptor()};
  LineReader log_{FileDescriptor()};
};

}  // namespace binpick
