#include "models/input_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>

#include "models/errors.h"

namespace binpick {
namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

template <class T>
T value_at(const char* data, std::endian order) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), data, sizeof(T));
  if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Printable and short, for messages.
std::string quoted(std::string_view word) {
  std::string text;
  for (const char c : word.substr(0, 40)) text += (c >= ' ' && c <= '~') ? c : '?';
  return "'" + text + (word.size() > 40 ? "..." : "") + "'";
}

}  // namespace

InputBytes::InputBytes(const std::filesystem::path& file) : name_(file.string()) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("{}: no such file", name_));
  }
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw IoError(fmt::format("{}: cannot be read: {}", name_, error.message()));
  if (size > kMaxBytes) {
    throw InputError(fmt::format("{}: larger than {} MB; thin it out", name_, kMaxBytes >> 20));
  }
  std::ifstream stream(file, std::ios::binary);
  bytes_.resize(size);
  if (!stream.read(bytes_.data(), static_cast<std::streamsize>(size))) {
    throw IoError(fmt::format("{}: cannot be read", name_));
  }
}

InputBytes::InputBytes(std::string bytes, std::string name)
    : bytes_(std::move(bytes)), name_(std::move(name)) {}

std::string_view InputBytes::line() {
  const std::string_view text = rest();
  const std::size_t end = text.find('\n');
  std::string_view found = text.substr(0, end);
  position_ += end == std::string_view::npos ? text.size() : end + 1;
  if (found.ends_with('\r')) found.remove_suffix(1);
  return found;
}

std::string_view InputBytes::word() {
  while (position_ < bytes_.size() && is_space(bytes_[position_])) ++position_;
  const std::size_t first = position_;
  while (position_ < bytes_.size() && !is_space(bytes_[position_])) ++position_;
  return std::string_view(bytes_).substr(first, position_ - first);
}

std::string_view InputBytes::take(std::size_t count, std::string_view what) {
  if (count > remaining()) {
    fail_binary(bytes_.size(), fmt::format("the file ends within {} ({} of {} bytes); it is "
                                           "truncated, fetch it again",
                                           what, remaining(), count));
  }
  const std::string_view found = rest().substr(0, count);
  position_ += count;
  return found;
}

double InputBytes::text_number(std::string_view what) {
  const std::string_view found = word();
  const std::size_t offset = position_ - found.size();
  if (found.empty()) {
    fail_text(offset, fmt::format("the file ends where {} should be; it is truncated", what));
  }
  double value = 0.0;
  const char* first = found.data() + (found.front() == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(first, found.data() + found.size(), value);
  if (error != std::errc() || end != found.data() + found.size()) {
    fail_text(offset, fmt::format("{} where {} should be", quoted(found), what));
  }
  return value;
}

std::int64_t InputBytes::text_integer(std::string_view what, std::int64_t min, std::int64_t max) {
  const std::string_view found = word();
  const std::size_t offset = position_ - found.size();
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
  if (found.empty() || error != std::errc() || end != found.data() + found.size()) {
    fail_text(offset, fmt::format("{} where {} should be, a whole number", quoted(found), what));
  }
  if (value < min || value > max) {
    fail_text(offset, fmt::format("{} is {}, outside [{}, {}]", what, value, min, max));
  }
  return value;
}

void InputBytes::fail_text(std::size_t offset, std::string_view message) const {
  const std::string_view before = std::string_view(bytes_).substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t line_begin = before.rfind('\n');
  const std::size_t column =
      line_begin == std::string_view::npos ? before.size() + 1 : before.size() - line_begin;
  throw InputError(fmt::format("{}:{}:{}: {}", name_, line, column, message));
}

void InputBytes::fail_binary(std::size_t offset, std::string_view message) const {
  throw InputError(fmt::format("{}: byte {}: {}", name_, offset, message));
}

double read_scalar(const char* data, ScalarType type, std::endian order) {
  using Kind = ScalarType::Kind;
  switch (type.size) {
    case 1:
      return type.kind == Kind::kSigned ? value_at<std::int8_t>(data, order)
                                        : value_at<std::uint8_t>(data, order);
    case 2:
      return type.kind == Kind::kSigned ? value_at<std::int16_t>(data, order)
                                        : value_at<std::uint16_t>(data, order);
    case 4:
      if (type.kind == Kind::kFloat) return static_cast<double>(value_at<float>(data, order));
      return type.kind == Kind::kSigned ? value_at<std::int32_t>(data, order)
                                        : value_at<std::uint32_t>(data, order);
    default:
      if (type.kind == Kind::kFloat) return value_at<double>(data, order);
      return type.kind == Kind::kSigned ? static_cast<double>(value_at<std::int64_t>(data, order))
                                        : static_cast<double>(value_at<std::uint64_t>(data, order));
  }
}

}  // namespace binpick
