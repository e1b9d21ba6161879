#pragma once

#include <sys/types.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "temporary_folder.h"

namespace binpick {

struct ChildOptions {
  std::filesystem::path directory = "/";
  std::map<std::string, std::string> environment;  ///< on top of this process's
  std::optional<std::uintmax_t> file_size_limit;   ///< bytes
  bool unprivileged = false;                       ///< as nobody, when the test runs as root
};

/// Another program under test, with its output in files.
class ChildProcess {
 public:
  ChildProcess(const std::vector<std::string>& arguments, const ChildOptions& options = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  void send(int signal) const;
  /// Exit code, or minus the signal that ended it.
  int wait();
  /// After wait.
  [[nodiscard]] std::string out() const { return read_whole_file(folder_ / "out"); }
  [[nodiscard]] std::string err() const { return read_whole_file(folder_ / "err"); }
  /// Its children that live now.
  [[nodiscard]] std::vector<pid_t> children() const;

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
};

/// Is there a process of this id that is no zombie?
[[nodiscard]] bool alive(pid_t pid);

}  // namespace binpick
