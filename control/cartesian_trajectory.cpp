#include "control/cartesian_trajectory.h"

#include <algorithm>
#include <cmath>

#include "models/errors.h"

namespace binpick {
namespace {

/// `limits` of a motion over `travel` as limits of a parameter in [0, 1], lowering those in
/// `slowest`.
void slow_down(MotionLimits& slowest, const MotionLimits& limits, double travel) {
  slowest.velocity = std::min(slowest.velocity, limits.velocity / travel);
  slowest.acceleration = std::min(slowest.acceleration, limits.acceleration / travel);
  slowest.jerk = std::min(slowest.jerk, limits.jerk / travel);
}

}  // namespace

CartesianMotionLimits CartesianMotionLimits::at_speed(double metres_per_second) noexcept {
  CartesianMotionLimits limits;
  limits.linear.velocity = metres_per_second;
  return limits;
}

CartesianTrajectory::CartesianTrajectory(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                                         const CartesianMotionLimits& limits)
    : from_(from), to_(to), travel_(to.translation() - from.translation()) {
  if (!from.matrix().allFinite() || !to.matrix().allFinite()) {
    throw InputError("Cartesian trajectory: start and goal must be finite");
  }
  const Eigen::AngleAxisd turn(
      Eigen::Quaterniond(to.linear() * from.linear().transpose()).normalized());
  rotation_ = turn.angle() * turn.axis();

  constexpr double kNegligible = 1e-9;  // m and rad: below, a motion sets no pace
  const double length = travel_.norm();
  const double angle = rotation_.norm();
  if (length < kNegligible && angle < kNegligible) return;
  constexpr double kUnlimited = 1e12;
  MotionLimits slowest{kUnlimited, kUnlimited, kUnlimited};
  if (length >= kNegligible) slow_down(slowest, limits.linear, length);
  if (angle >= kNegligible) slow_down(slowest, limits.angular, angle);
  profile_ = DoubleSProfile(1.0, slowest);
}

CartesianTarget CartesianTrajectory::sample(double t) const noexcept {
  if (t >= profile_.duration()) return {to_, Vector6::Zero(), Vector6::Zero()};
  const PathState path = profile_.sample(t);
  const double angle = rotation_.norm();
  CartesianTarget sample;
  sample.T_world_tcp = from_;
  sample.T_world_tcp.translation() += path.position * travel_;
  if (angle > 0.0) {
    const Eigen::AngleAxisd turn(path.position * angle, rotation_ / angle);
    sample.T_world_tcp.linear() = turn.toRotationMatrix() * from_.linear();
  }
  sample.twist << path.velocity * travel_, path.velocity * rotation_;
  sample.acceleration << path.acceleration * travel_, path.acceleration * rotation_;
  return sample;
}

CartesianTrajectory CartesianTrajectory::stretched_to(double duration) const noexcept {
  CartesianTrajectory slower = *this;
  slower.profile_ = profile_.stretched_to(duration);
  return slower;
}

}  // namespace binpick
