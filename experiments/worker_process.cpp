#include "experiments/worker_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "models/errors.h"

namespace binpick {
namespace {

struct Pipe {
  FileDescriptor read;
  FileDescriptor write;
};

Pipe make_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    throw IoError(fmt::format("cannot make a pipe to a worker: {}", std::strerror(errno)));
  }
  return {FileDescriptor(ends[0]), FileDescriptor(ends[1])};
}

// Runs between fork and exec, where only async-signal-safe calls are allowed.
[[noreturn]] void become_worker(pid_t parent, int orders, int replies, int log) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  // A Ctrl-C goes to the whole terminal; the parent alone decides what becomes of its workers.
  ::setpgid(0, 0);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  // First out of the way: a source may sit where a target belongs.
  orders = ::fcntl(orders, F_DUPFD, 10);
  replies = ::fcntl(replies, F_DUPFD, 10);
  log = ::fcntl(log, F_DUPFD, 10);
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  ::dup2(orders, kWorkerOrders);
  ::dup2(replies, kWorkerReplies);
  for (const int copy : {orders, replies, log}) ::close(copy);
  ::execl("/proc/self/exe", "binpick", "worker", static_cast<char*>(nullptr));
  ::_exit(127);
}

}  // namespace

WorkerProcess::WorkerProcess() {
  Pipe orders = make_pipe();
  Pipe replies = make_pipe();
  Pipe log = make_pipe();
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw IoError(fmt::format("cannot start a worker: {}", std::strerror(errno)));
  if (child == 0) become_worker(parent, orders.read.get(), replies.write.get(), log.write.get());
  pid_.value = child;
  orders_ = std::move(orders.write);
  replies_ = LineReader(std::move(replies.read));
  log_ = LineReader(std::move(log.read));
}

WorkerProcess::~WorkerProcess() {
  if (pid_.value < 0) return;
  kill();
  (void)wait();
}

bool WorkerProcess::send(const WorkerOrder& order) {
  return write_line(orders_.get(), encode(order));
}

double WorkerProcess::processor_time() const noexcept {
  clockid_t clock{};
  timespec time{};
  if (pid_.value < 0 || ::clock_getcpuclockid(pid_.value, &clock) != 0) return 0.0;
  if (::clock_gettime(clock, &time) != 0) return 0.0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void WorkerProcess::kill() noexcept {
  if (pid_.value > 0) ::kill(pid_.value, SIGKILL);
}

ProcessEnd WorkerProcess::wait() {
  int status = 0;
  while (::waitpid(pid_.value, &status, 0) < 0 && errno == EINTR) {
  }
  pid_.value = -1;
  if (!WIFSIGNALED(status)) return {fmt::format("exit code {}", WEXITSTATUS(status)), false};
  const int signal = WTERMSIG(status);
  const char* name = ::sigabbrev_np(signal);
  return {fmt::format("signal {} (SIG{})", signal, name == nullptr ? "?" : name),
          signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP};
}

}  // namespace binpick
