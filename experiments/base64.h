#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace binpick {

/// RFC 4648, with padding, without line breaks.
[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// The bytes of `numbers` as they lie in memory: little-endian on the machines that binpick runs
/// on.
template <class Number>
[[nodiscard]] std::string base64_of(const std::vector<Number>& numbers) {
  return base64(std::as_bytes(std::span(numbers)));
}

}  // namespace binpick
