#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "models/geometry.h"
#include "models/robot_description.h"

namespace binpick {

/// A parallel, self-centring two-jaw gripper. Frames: `gripper` is the flange frame (z away from
/// the arm); the tool centre lies between the pads; jaws move along +-y of both.
struct GripperDescription {
  Interval stroke;         ///< distance between the pads, m
  double max_force = 0.0;  ///< N
  Interval speed;          ///< of the distance between the pads, m/s
  double closed_width =
      0.0;  ///< below this after closing, the grasp has failed ("completely closed")

  Eigen::Isometry3d T_flange_tcp = Eigen::Isometry3d::Identity();
  BodyInertia body;  ///< housing, in the flange frame
  BodyInertia jaw;   ///< one jaw, about its pad centre, tool axes
  Eigen::Vector3d body_size = Eigen::Vector3d::Zero();  ///< housing box below the flange, m
  double pad_width = 0.0;                               ///< along x, m
  double pad_height = 0.0;                              ///< along z, m
  double finger_length = 0.0;                           ///< from the housing to the tip, m
  double finger_thickness = 0.0;                        ///< along y, m
  double tip_beyond_tcp = 0.0;  ///< how far the finger tips reach past the tool centre, m

  /// Housing and both jaws as one body at `width`, in the flange frame: the tool that the arm
  /// carries.
  [[nodiscard]] BodyInertia tool_inertia(double width) const;
};

/// @throws InputError with file:line:col.
[[nodiscard]] GripperDescription load_gripper_description(const std::filesystem::path& file);

/// The gripper of this repository, models/gripper/gripper.yaml.
[[nodiscard]] GripperDescription load_gripper();

}  // namespace binpick
