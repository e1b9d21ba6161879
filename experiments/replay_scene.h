#pragma once

#include <nlohmann/json.hpp>

#include "sim/world.h"

namespace binpick {

/// The bodies of a world that can move, by MuJoCo's numbers, in their order.
[[nodiscard]] std::vector<int> moving_bodies(const mjModel& model);

/// What is seen of a world, for the report's 3-D view:
///
///   shapes   meshes, each once: vertices in multiples of `step` (m, per axis) from `lowest`,
///            as base64 of 16-bit numbers; triangles as base64 of vertex numbers, 16 bits each, or
///            32 in meshes of more than 65536 vertices
///   bodies   names of the moving bodies
///   parts    body (its place in `bodies`, -1 for the cell), kind, size (half lengths as MuJoCo
///            has them, m) or shape, pose in the body (x y z, quaternion x y z w), colour (RGBA)
///   camera   position and look_at of the scene's picture, m
///
/// Worlds of one template have the same scene.
[[nodiscard]] nlohmann::json replay_scene(const World& world);

}  // namespace binpick
