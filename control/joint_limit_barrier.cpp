#include "control/joint_limit_barrier.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr double kTopSpeed = 0.92;
constexpr double kTime = 0.008;                   // T, s
constexpr double kRateShare = 0.5;                // s
constexpr double kSteepestApproach = 1.0 / 0.03;  // of k, 1/s
// Of its effort that a joint has for braking before a position limit.
constexpr double kBrakingShare = 0.4;
// Below this share of its top speed a joint may be leaning on something.
constexpr double kSlowShare = 0.5;
constexpr int kSweeps = 20;
constexpr double kTolerance = 0.1;  // rad/s^2

/// The largest acceleration towards a side, for a joint that moves there at `rate` and may go at
/// `top` and has `way` left.
double largest_acceleration(double rate, double top, double way, double k, double jerk,
                            double dt) noexcept {
  const double near_limit = k * std::max(way, 0.0);
  const double left = std::min(top, near_limit) - rate;
  const double closing = near_limit < top ? k * std::max(rate, 0.0) : 0.0;
  const double room = std::max(left, 0.0);
  return std::min(left / kTime - closing, jerk * (std::sqrt(dt * dt + 2.0 * room / jerk) - dt));
}

}  // namespace

JointVector JointLimitBarrier::keep(const JointVector& tau, const TorqueRange& range,
                                    const Motion& motion, double dt) const noexcept {
  const JointMatrix& M = motion.dynamics.M;
  const JointVector unbalanced = tau - motion.dynamics.gravity - motion.dynamics.coriolis;
  JointVector qdd = motion.space.acceleration_of(unbalanced);
  const JointVector leaning = motion.space.acceleration_of(motion.residual);

  JointVector most;
  JointVector least;
  const auto find_bounds = [&](int i, double jerk) {
    const double top = kTopSpeed * limits_.velocity[i];
    const double k = std::min(kSteepestApproach,
                              kBrakingShare * limits_.effort[i] / (M(i, i) * limits_.velocity[i]));
    const double rate = motion.rate[i];
    most[i] = largest_acceleration(rate, top, limits_.upper[i] - motion.q[i], k, jerk, dt);
    least[i] = -largest_acceleration(-rate, top, motion.q[i] - limits_.lower[i], k, jerk, dt);
  };
  // (M^-1)_ii >= 1 / M_ii: a bound that is quick to find, and mostly far away.
  bool watched = false;
  for (int i = 0; i < kArmJoints; ++i) {
    if (std::abs(motion.rate[i]) < kSlowShare * kTopSpeed * limits_.velocity[i]) {
      qdd[i] += leaning[i];
    }
    find_bounds(i, kRateShare * torque_rate_ / M(i, i));
    watched = watched || qdd[i] > most[i] || qdd[i] < least[i];
  }
  if (!watched) return tau;

  JointMatrix response;  // M^-1
  for (int i = 0; i < kArmJoints; ++i) {
    response.col(i) = motion.space.acceleration_of(JointVector::Unit(i));
    find_bounds(i, kRateShare * torque_rate_ * response(i, i));
  }
  JointVector kept = tau;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool settled = true;
    for (int i = 0; i < kArmJoints; ++i) {
      const double excess = qdd[i] - std::clamp(qdd[i], least[i], most[i]);
      if (std::abs(excess) <= kTolerance) continue;
      const double wanted = kept[i] - excess / response(i, i);
      const double next = std::clamp(wanted, range.lowest[i], range.highest[i]);
      settled = settled && next == kept[i];
      qdd += (next - kept[i]) * response.col(i);
      kept[i] = next;
    }
    if (settled) break;
  }
  return kept;
}

}  // namespace binpick
