#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "models/config_visitor.h"
#include "models/object_model.h"

namespace binpick {

/// Grasps that differ only in where they stand round the object, as a description file lists them.
/// Every combination of turn, shift, tilt and wrist is one grasp.
struct GraspFamily {
  std::string name;
  Eigen::Vector3d approach = -Eigen::Vector3d::UnitZ();   ///< unit, model frame
  Eigen::Vector3d jaw = Eigen::Vector3d::UnitY();         ///< unit, across the approach
  Eigen::Vector3d tool_centre = Eigen::Vector3d::Zero();  ///< m, model frame
  double pre_opening = 0.0;                               ///< m
  double expected_width = 0.0;                            ///< m
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ();   ///< through the model's origin
  std::vector<double> turns{0.0};   ///< rad, of the whole grasp about turn_axis
  std::vector<double> shifts{0.0};  ///< m, along the pads' width
  std::vector<double> tilts{0.0};   ///< rad, of the approach about the jaw axis
  bool both_wrists = true;          ///< also half a turn about the approach: the jaws are alike

  void visit(ConfigVisitor& visitor);

  /// All members: turns, then shifts, tilts, wrists. The one without turn, shift and tilt bears the
  /// family's name alone.
  [[nodiscard]] std::vector<Grasp> expand() const;
};

}  // namespace binpick
