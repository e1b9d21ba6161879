#include <cstddef>
#include <cstdint>
#include <string>

#include "models/errors.h"
#include "models/yaml_config.h"
#include "scenes/scene.h"

/// A scene file, read strictly; files that it extends are not looked for.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    binpick::Scene scene;
    binpick::read_yaml_text(std::string(reinterpret_cast<const char*>(data), size), "fuzzed",
                            [&](binpick::ConfigVisitor& visitor) { scene.visit(visitor); });
    static_cast<void>(scene.validate());
  } catch (const binpick::InputError&) {
  }
  return 0;
}
