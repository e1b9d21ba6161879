#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "models/cell_layout.h"
#include "models/gripper_description.h"

namespace binpick {

struct PushOptions {
  /// Things are pushed towards this distance from the base axis, where the arm reaches objects in
  /// any orientation from above, m.
  double comfortable_radius = 0.55;
  double tip_height = 0.012;  ///< of the finger tips above the table, m
  /// Room between the fingers and the pushed thing at first, half the fingers included, m.
  double margin = 0.020;
  /// Half the width of the lane along which the closed fingers come, with room on either side, m.
  double lane = 0.025;
  double longest = 0.15;            ///< way along which is pushed, m
  double approach_distance = 0.10;  ///< before the start, along the approach vector, m
};

/// Tool poses of a push with closed fingers: down to `T_world_start`, on along a straight line.
struct Push {
  Eigen::Isometry3d T_world_before = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_start = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_end = Eigen::Isometry3d::Identity();
};

/// How to push something radially, seen from the base, to where it can be grasped: outward what
/// lies nearer than the comfortable radius, inward the rest. Near the base the arm reaches low
/// poses only with the tool leaning outward, over the pushed thing, so the fingers set out that
/// much farther from it: less far with the finger tips at half the thing's height, which is tried
/// after all leans with low tips. The least lean at which `feasible` agrees is taken.
/// @param surface points of the thing, world frame, m; closer together than the lane is wide.
/// @returns nothing if no lean up to 50 degrees is feasible, or nothing is gained.
[[nodiscard]] std::optional<Push> plan_push(const std::vector<Eigen::Vector3d>& surface,
                                            const CellLayout& layout,
                                            const GripperDescription& gripper,
                                            const std::function<bool(const Push&)>& feasible,
                                            const PushOptions& options = {});

}  // namespace binpick
