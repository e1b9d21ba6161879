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
  const JointVector unbalanced = tau - motion.dynamics.gravity - motion.dynamics.coriolis;
  JointVector qdd = motion.space.acceleration_of(unbalanced);
  const JointVector pushed = motion.space.acceleration_of(motion.push);
  JointVector more = JointVector::Zero();  // than qdd, should the arm still be pushed
  JointVector less = JointVector::Zero();
  for (int i = 0; i < kArmJoints; ++i) {
    if (std::abs(motion.rate[i]) < kSlowShare * kTopSpeed * limits_.velocity[i]) {
      qdd[i] += pushed[i];
    } else {
      more[i] = std::max(pushed[i], 0.0);
      less[i] = std::max(-pushed[i], 0.0);
    }
  }

  const JointMatrix& response = motion.space.M_inverse();
  JointVector most;
  JointVector least;
  for (int i = 0; i < kArmJoints; ++i) {
    const double jerk = kRateShare * torque_rate_ * response(i, i);
    const double top = kTopSpeed * limits_.velocity[i];
    const double k =
        std::min(kSteepestApproach, kBrakingShare * limits_.effort[i] /
                                        (motion.dynamics.M(i, i) * limits_.velocity[i]));
    const double rate = motion.rate[i];
    const double way_up = limits_.upper[i] - motion.q[i];
    const double way_down = motion.q[i] - limits_.lower[i];
    most[i] = largest_acceleration(rate, top, way_up, k, jerk, dt) - more[i];
    least[i] = less[i] - largest_acceleration(-rate, top, way_down, k, jerk, dt);
  }

  JointVector kept = tau;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool settled = true;
    for (int i = 0; i < kArmJoints; ++i) {
      if (qdd[i] >= least[i] && qdd[i] <= most[i]) continue;
      const bool backward = motion.rate[i] > 0.0 ? qdd[i] < least[i] : qdd[i] > most[i];
      if (backward && motion.touched) continue;
      // Of a joint that is pushed too hard for both, the side that it moves to comes first.
      const double bounded = motion.rate[i] > 0.0 ? std::min(std::max(qdd[i], least[i]), most[i])
                                                  : std::max(std::min(qdd[i], most[i]), least[i]);
      const double excess = qdd[i] - bounded;
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
