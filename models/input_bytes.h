#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace binpick {

/// A file's bytes and a place in them, for readers of formats that mix text and binary parts.
/// Readers never hold more than a small multiple of the file's own size.
class InputBytes {
 public:
  static constexpr std::uintmax_t kMaxBytes = std::uintmax_t{2} << 30;

  /// @throws InputError for a missing or huge file, IoError when it cannot be read.
  explicit InputBytes(const std::filesystem::path& file);
  /// A copy of `bytes`; `name` stands for the file in messages.
  InputBytes(std::string_view bytes, std::string name);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }
  [[nodiscard]] std::string_view rest() const { return bytes_.substr(position_); }
  void seek(std::size_t position) { position_ = position; }

  /// The next line without its end, which may be \n or \r\n. Empty at the end of the file.
  std::string_view line();
  /// The next word after white space, line ends included; empty at the end of the file.
  std::string_view word();
  /// The next `count` bytes. @throws InputError `file: byte N: ...` when the file ends before.
  std::string_view take(std::size_t count, std::string_view what);

  /// A number written as text. @throws InputError `file:line:col: ...` for anything else.
  double text_number(std::string_view what);
  std::int64_t text_integer(std::string_view what, std::int64_t min, std::int64_t max);

  /// `file:line:col: message`, for what begins at `offset`.
  [[noreturn]] void fail_text(std::size_t offset, std::string_view message) const;
  /// `file: byte N: message`.
  [[noreturn]] void fail_binary(std::size_t offset, std::string_view message) const;

 private:
  std::unique_ptr<char[]> memory_;
  std::string_view bytes_;
  std::string name_;
  std::size_t position_ = 0;
};

}  // namespace binpick
