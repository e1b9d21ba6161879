#pragma once

#include <vector>

#include "models/object_model.h"
#include "models/random.h"

namespace binpick {

/// The physical parameters of one object in one trial.
struct ObjectDraw {
  double mass = 0.0;             ///< kg
  double table_friction = 0.0;   ///< against table, bins and frame
  double object_friction = 0.0;  ///< against others; two objects take the mean of theirs
  double pad_friction = 0.0;     ///< against the gripper's pads
};

/// The physical parameters of one trial, one entry per object of the scene.
struct PhysicsDraw {
  std::vector<ObjectDraw> objects;
};

/// The centres of the models' ranges.
[[nodiscard]] PhysicsDraw centre_physics(const std::vector<ObjectModel>& models);

/// Uniform in the models' ranges. Object i draws from its own stream derive_seed(seed, i).
[[nodiscard]] PhysicsDraw draw_physics(const std::vector<ObjectModel>& models, Seed seed);

}  // namespace binpick
