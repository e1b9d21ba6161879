#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "models/lzf.h"

/// The first two bytes say which size is asked for; what comes back must have it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::size_t wanted = data[0] + 256u * data[1];
  const std::string_view packed(reinterpret_cast<const char*>(data) + 2, size - 2);
  const auto plain = binpick::unpack_lzf(packed, wanted);
  if (plain && plain->size() != wanted) std::abort();
  return 0;
}
