#include "experiments/timing_turn.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "models/errors.h"

namespace binpick {

TimingTurn::TimingTurn() {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("binpick-timing-{}.lock", ::getuid());
  descriptor_ = ::open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
  int locked = -1;
  while (descriptor_ >= 0 && (locked = ::flock(descriptor_, LOCK_EX)) != 0 && errno == EINTR) {
  }
  if (locked == 0) return;
  const std::string why = std::strerror(errno);
  if (descriptor_ >= 0) ::close(descriptor_);
  throw IoError(file.string() + ": cannot be locked: " + why);
}

TimingTurn::~TimingTurn() { ::close(descriptor_); }

}  // namespace binpick
