#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace binpick {

/// Unpacks LZF, the compression of PCD files: exactly `size` bytes, or nothing when the packed
/// bytes are damaged or of another length.
[[nodiscard]] std::optional<std::string> unpack_lzf(std::string_view packed, std::size_t size);

/// The most bytes that `packed_size` packed ones can unpack to.
[[nodiscard]] constexpr std::size_t lzf_bound(std::size_t packed_size) noexcept {
  return 88 * packed_size + 264;  // three bytes stand for at most 264
}

}  // namespace binpick
