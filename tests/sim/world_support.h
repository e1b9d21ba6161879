#pragma once

#include <map>
#include <memory>
#include <string>

#include "sim/physics_draw.h"
#include "sim/world.h"

namespace binpick::testing {

/// The compiled cell of scenes/`name`.yaml, made once per test program.
inline std::shared_ptr<const WorldTemplate> cell(const std::string& name) {
  static std::map<std::string, std::shared_ptr<const WorldTemplate>> made;
  auto& entry = made[name];
  if (!entry) {
    entry = make_world_template(
        load_scene(std::string(BINPICK_SOURCE_DIR "/scenes/") + name + ".yaml"));
  }
  return entry;
}

/// A world of that cell with physics at the centres of their ranges.
inline World make_world(const std::string& name) {
  const auto shared = cell(name);
  return World(shared, centre_physics(shared->parts.objects));
}

inline void step_for(World& world, double seconds) {
  for (double end = world.time() + seconds - 0.5 * World::kStep; world.time() < end;) world.step();
}

}  // namespace binpick::testing
