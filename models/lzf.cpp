#include "models/lzf.h"

#include <cstring>

namespace binpick {

std::optional<std::string> unpack_lzf(std::string_view packed, std::size_t size) {
  if (size > lzf_bound(packed.size())) return std::nullopt;
  std::string out(size, '\0');
  std::size_t end = 0;  // of what is unpacked
  std::size_t at = 0;   // in `packed`
  const auto next = [&]() {
    return static_cast<std::size_t>(static_cast<unsigned char>(packed[at++]));
  };
  while (at < packed.size()) {
    const std::size_t control = next();
    if (control < 32) {  // a run of control + 1 plain bytes
      const std::size_t length = control + 1;
      if (length > packed.size() - at || length > size - end) return std::nullopt;
      std::memcpy(out.data() + end, packed.data() + at, length);
      end += length;
      at += length;
      continue;
    }
    // A copy of length 3..264 from up to 8 KiB back.
    std::size_t length = control >> 5;
    if (length == 7) {
      if (at >= packed.size()) return std::nullopt;
      length += next();
    }
    length += 2;
    if (at >= packed.size()) return std::nullopt;
    const std::size_t back = ((control & 31) << 8) + next() + 1;
    if (back > end || length > size - end) return std::nullopt;
    // Byte by byte: source and destination may overlap.
    for (const std::size_t stop = end + length; end < stop; ++end) out[end] = out[end - back];
  }
  if (end != size) return std::nullopt;
  return out;
}

}  // namespace binpick
