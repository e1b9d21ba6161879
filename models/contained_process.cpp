#include "models/contained_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>

#include "models/errors.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define BINPICK_RESERVES_ADDRESS_SPACE 1
#else
#define BINPICK_RESERVES_ADDRESS_SPACE 0
#endif

namespace binpick {
namespace {

// The first byte of the stream says what follows.
constexpr char kAnswer = 'a';
constexpr char kProblem = 'p';

class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { close_now(); }
  void close_now() {
    if (descriptor_ >= 0) close(descriptor_);
    descriptor_ = -1;
  }
  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::size_t address_space_in_use() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

void limit(int resource, rlim_t value) {
  rlimit bounds{};
  getrlimit(static_cast<__rlimit_resource>(resource), &bounds);
  bounds.rlim_cur = std::min(value, bounds.rlim_max);
  setrlimit(static_cast<__rlimit_resource>(resource), &bounds);
}

/// SIGPROF ends the process after `seconds` of processor time; RLIMIT_CPU knows whole seconds only.
void limit_processor_time(double seconds) {
  itimerval timer{};
  const double whole = std::floor(seconds);
  timer.it_value.tv_sec = static_cast<time_t>(whole);
  timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - whole)) + 1;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

void write_all(int descriptor, const void* data, std::size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(descriptor, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(1);
    next += written;
    size -= static_cast<std::size_t>(written);
  }
}

[[noreturn]] void run_child(int descriptor, const std::function<std::vector<std::byte>()>& work,
                            const ContainmentLimits& limits) {
  for (const int signal : {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGPIPE, SIGPROF}) {
    std::signal(signal, SIG_DFL);
  }
  limit(RLIMIT_CORE, 0);
  limit_processor_time(limits.cpu_seconds);
  // Sanitizers reserve terabytes of address space of which they use little.
  if (!BINPICK_RESERVES_ADDRESS_SPACE) {
    limit(RLIMIT_AS, address_space_in_use() + limits.memory_bytes);
  }
  // What a library complains about comes back as the problem, not on the terminal.
  const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (null >= 0) {
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
  }
  try {
    const std::vector<std::byte> answer = work();
    write_all(descriptor, &kAnswer, 1);
    write_all(descriptor, answer.data(), answer.size());
  } catch (const std::bad_alloc&) {
    const char text[] = "pneeds too much memory";
    write_all(descriptor, text, sizeof(text) - 1);
  } catch (const std::exception& error) {
    write_all(descriptor, &kProblem, 1);
    write_all(descriptor, error.what(), std::strlen(error.what()));
  }
  _exit(0);
}

enum class ReadEnd { kComplete, kTimeout, kTooLong };

ReadEnd read_stream(int descriptor, const ContainmentLimits& limits, std::vector<std::byte>& out) {
  using Clock = std::chrono::steady_clock;
  const auto deadline =
      Clock::now() + std::chrono::milliseconds(static_cast<long>(1000.0 * limits.wall_seconds));
  std::vector<std::byte> buffer(1u << 16);
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return ReadEnd::kTimeout;
    pollfd waiting{descriptor, POLLIN, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min<long>(left.count(), 1000)));
    if (ready <= 0) continue;
    const ssize_t count = read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return ReadEnd::kComplete;
    if (out.size() + static_cast<std::size_t>(count) > limits.output_bytes) {
      return ReadEnd::kTooLong;
    }
    out.insert(out.end(), buffer.begin(), buffer.begin() + count);
  }
}

std::string describe_end(int status, const ContainmentLimits& limits) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF) {
    return fmt::format("takes longer than {:.3g} s of processor time", limits.cpu_seconds);
  }
  if (WIFSIGNALED(status)) return fmt::format("crashes its reader (signal {})", WTERMSIG(status));
  return "ends its reader early";
}

}  // namespace

ContainedResult run_contained(const std::function<std::vector<std::byte>()>& work,
                              const ContainmentLimits& limits) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    throw IoError(fmt::format("cannot open a pipe: {}", std::strerror(errno)));
  }
  FileDescriptor reading(ends[0]);
  FileDescriptor writing(ends[1]);
  const pid_t child = fork();
  if (child < 0) throw IoError(fmt::format("cannot fork: {}", std::strerror(errno)));
  if (child == 0) run_child(writing.get(), work, limits);
  writing.close_now();

  std::vector<std::byte> stream;
  const ReadEnd end = read_stream(reading.get(), limits, stream);
  if (end != ReadEnd::kComplete) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ContainedResult result;
  if (end == ReadEnd::kTimeout) {
    result.problem = fmt::format("takes longer than {} s", limits.wall_seconds);
  } else if (end == ReadEnd::kTooLong) {
    result.problem = "is too large";
  } else if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || stream.empty()) {
    result.problem = describe_end(status, limits);
  } else if (stream.front() == std::byte{kProblem}) {
    result.problem.assign(reinterpret_cast<const char*>(stream.data()) + 1, stream.size() - 1);
  } else {
    result.ok = true;
    result.bytes.assign(stream.begin() + 1, stream.end());
  }
  return result;
}

}  // namespace binpick
