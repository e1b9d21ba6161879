#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace binpick {

/// The finite group of rotations that `generators` span, identity first, in the order in which
/// products of generators reach them; nothing when it has more than `max_order` elements.
[[nodiscard]] std::optional<std::vector<Eigen::Isometry3d>> rotation_group(
    const std::vector<Eigen::Matrix3d>& generators, std::size_t max_order = 120);

}  // namespace binpick
