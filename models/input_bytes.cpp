#include "models/input_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <utility>

#include "models/errors.h"

namespace binpick {
namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

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
  // Read rather than mapped: a file that shrinks meanwhile is an error, not a signal.
  memory_ = std::make_unique_for_overwrite<char[]>(size);
  bytes_ = {memory_.get(), size};
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(memory_.get(), static_cast<std::streamsize>(size))) {
    throw IoError(fmt::format("{}: cannot be read", name_));
  }
}

InputBytes::InputBytes(std::string_view bytes, std::string name)
    : memory_(std::make_unique_for_overwrite<char[]>(bytes.size())),
      bytes_(memory_.get(), bytes.size()),
      name_(std::move(name)) {
  std::copy(bytes.begin(), bytes.end(), memory_.get());
}

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
  return bytes_.substr(first, position_ - first);
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
  const std::string_view before = bytes_.substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t line_begin = before.rfind('\n');
  const std::size_t column =
      line_begin == std::string_view::npos ? before.size() + 1 : before.size() - line_begin;
  throw InputError(fmt::format("{}:{}:{}: {}", name_, line, column, message));
}

void InputBytes::fail_binary(std::size_t offset, std::string_view message) const {
  throw InputError(fmt::format("{}: byte {}: {}", name_, offset, message));
}

}  // namespace binpick
