#pragma once

#include <Eigen/Geometry>

#include "control/operational_space.h"
#include "models/robot_description.h"

namespace binpick {

/// Mass and centre of mass of what the gripper holds, from the wrench that the observer feels at
/// the tool centre while the arm stands still: with gravity g in tool axes and h = m c,
///   f = m g,   t = c x f = -[g]x h,
/// both linear, solved by least squares over all samples. Along gravity c shows only in another
/// orientation of the tool; until then it is taken as zero there.
class PayloadEstimator {
 public:
  /// @param wrench estimated external wrench on the tool centre, world axes.
  void add(const Vector6& wrench, const Eigen::Isometry3d& T_world_tcp) noexcept;

  /// In the tool-centre frame, as a point mass; zero before the first sample. No lighter than
  /// nothing, and within `reach` of the tool centre.
  [[nodiscard]] BodyInertia estimate(double reach = 0.15) const noexcept;
  [[nodiscard]] int samples() const noexcept { return samples_; }

 private:
  int samples_ = 0;
  double weight_ = 0.0;                                       ///< sum of g.f
  Eigen::Matrix3d moments_ = Eigen::Matrix3d::Zero();         ///< sum of [g]x^T [g]x
  Eigen::Vector3d torque_moments_ = Eigen::Vector3d::Zero();  ///< sum of -[g]x^T t
};

}  // namespace binpick
