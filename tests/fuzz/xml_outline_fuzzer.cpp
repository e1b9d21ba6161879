#include <cstddef>
#include <cstdint>
#include <string_view>

#include "models/errors.h"
#include "models/xml_outline.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const binpick::XmlOutline outline(std::string_view(reinterpret_cast<const char*>(data), size),
                                      "fuzzed");
    static_cast<void>(outline.locate("link", "arm"));
  } catch (const binpick::InputError&) {
  }
  return 0;
}
