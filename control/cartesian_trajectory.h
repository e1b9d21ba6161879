#pragma once

#include <Eigen/Geometry>

#include "control/double_s_profile.h"
#include "control/motion_target.h"

namespace binpick {

/// How fast the tool centre may move. With the defaults, 0.25 m/s are reached and left within
/// 2.6 cm. To reach 0.8 m/s inside a 0.1 m approach takes 8 m/s^2 and 400 m/s^3.
struct CartesianMotionLimits {
  MotionLimits linear{0.25, 4.0, 100.0};   ///< m/s, m/s^2, m/s^3
  MotionLimits angular{1.0, 10.0, 250.0};  ///< rad/s, rad/s^2, rad/s^3

  /// The defaults at another linear speed.
  [[nodiscard]] static CartesianMotionLimits at_speed(double metres_per_second) noexcept;
};

/// The tool centre on a straight line, turning about one fixed axis (slerp), both with the same
/// double-S profile, from rest to rest.
class CartesianTrajectory {
 public:
  /// @throws InputError if a pose is not finite or a limit not positive.
  CartesianTrajectory(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                      const CartesianMotionLimits& limits = {});

  /// Before 0 the start, after `duration()` the end. Allocates nothing.
  [[nodiscard]] CartesianTarget sample(double t) const noexcept;

  [[nodiscard]] double duration() const noexcept { return profile_.duration(); }
  [[nodiscard]] const Eigen::Isometry3d& goal() const noexcept { return to_; }

  /// The same motion drawn out to `duration`; a shorter one changes nothing.
  [[nodiscard]] CartesianTrajectory stretched_to(double duration) const noexcept;

 private:
  Eigen::Isometry3d from_;
  Eigen::Isometry3d to_;
  Eigen::Vector3d travel_;    // m, world
  Eigen::Vector3d rotation_;  // axis times angle, world
  DoubleSProfile profile_;    // over [0, 1]
};

}  // namespace binpick
