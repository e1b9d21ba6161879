#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace binpick {

/// An owned file descriptor.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) noexcept : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor() { reset(); }

  [[nodiscard]] int get() const noexcept { return descriptor_; }
  [[nodiscard]] int release() noexcept;
  void reset() noexcept;

 private:
  int descriptor_ = -1;
};

/// The lines that arrive on a descriptor.
class LineReader {
 public:
  explicit LineReader(FileDescriptor descriptor) : descriptor_(std::move(descriptor)) {}

  /// Reads once what has arrived (waits when nothing has). @return false at the end of the stream.
  bool fill();
  /// The next complete line, without its end.
  [[nodiscard]] std::optional<std::string> next();
  [[nodiscard]] int descriptor() const noexcept { return descriptor_.get(); }

 private:
  FileDescriptor descriptor_;
  std::string buffer_;
};

/// Writes the line and its end. @return false when nobody reads any more.
bool write_line(int descriptor, std::string_view line);

}  // namespace binpick
