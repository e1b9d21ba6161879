#include "experiments/line_pipe.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

namespace binpick {

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    reset();
    descriptor_ = other.release();
  }
  return *this;
}

int FileDescriptor::release() noexcept { return std::exchange(descriptor_, -1); }

void FileDescriptor::reset() noexcept {
  if (descriptor_ >= 0) ::close(release());
}

bool LineReader::fill() {
  std::array<char, 65536> block{};
  ssize_t count = 0;
  do {
    count = ::read(descriptor_.get(), block.data(), block.size());
  } while (count < 0 && errno == EINTR);
  if (count <= 0) return false;
  buffer_.append(block.data(), static_cast<std::size_t>(count));
  return true;
}

std::optional<std::string> LineReader::next() {
  const std::size_t end = buffer_.find('\n');
  if (end == std::string::npos) return std::nullopt;
  std::string line = buffer_.substr(0, end);
  buffer_.erase(0, end + 1);
  return line;
}

bool write_line(int descriptor, std::string_view line) {
  std::string rest(line);
  rest += '\n';
  std::string_view unsent = rest;
  while (!unsent.empty()) {
    const ssize_t count = ::write(descriptor, unsent.data(), unsent.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    unsent.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace binpick
