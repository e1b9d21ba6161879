#include "sim/physics_draw.h"

namespace binpick {

PhysicsDraw centre_physics(const std::vector<ObjectModel>& models) {
  PhysicsDraw draw;
  for (const ObjectModel& model : models) {
    const ObjectPhysics& physics = model.physics;
    draw.objects.push_back({physics.mass.centre(), physics.table_friction.centre(),
                            physics.object_friction.centre(), physics.pad_friction.centre()});
  }
  return draw;
}

PhysicsDraw draw_physics(const std::vector<ObjectModel>& models, Seed seed) {
  const auto within = [](const Interval& range, Seed stream, std::string_view purpose) {
    return Random(derive_seed(stream, purpose)).uniform(range.low, range.high);
  };
  PhysicsDraw draw;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const ObjectPhysics& physics = models[i].physics;
    const Seed stream = derive_seed(seed, std::uint64_t{i});
    draw.objects.push_back({within(physics.mass, stream, "mass"),
                            within(physics.table_friction, stream, "table friction"),
                            within(physics.object_friction, stream, "object friction"),
                            within(physics.pad_friction, stream, "pad friction")});
  }
  return draw;
}

}  // namespace binpick
