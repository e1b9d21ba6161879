#pragma once

#include "control/arm_model.h"
#include "control/operational_space.h"
#include "control/torque_limiter.h"

namespace binpick {

/// Keeps joints within their speeds and positions: a control barrier (Ames et al. 2019) behind the
/// torque limiter, on the torques that the motors really get. With u the speed that is still
/// allowed towards either side, a the acceleration and x the way to that side's position limit,
///   u = min(92 % of the speed limit, k x):
/// no joint may come nearer to u than exponentially, and none may accelerate so much that its own
/// torque, which changes no faster than the rate limit r, would bring it back too late:
///   a <= (u - qd) / T - k qd,        qd + a dt + a^2 / (2 j) <= u,
/// with -k qd only near the position limit, and the jerk j = s r (M^-1)_ii of a share s of the
/// torque rate; the rest is for what the other joints' torques do meanwhile.
///
/// A joint's own torque is what keeps it back. A slow joint is believed to lean on what pushes it;
/// for a fast one both must hold, with that push and without it, since it may end. The push is to
/// be known without lag: of a blow that lasts 30 ms the observer's residual, 20 ms late, shows a
/// third while it grows, and still shows it when it is over. In contact only the side that a joint
/// moves to is watched: less braking, for fear of what would come after it, would keep a bouncing
/// tool bouncing. What strikes the arm may still drive a joint beyond its speed; then it is braked.
class JointLimitBarrier {
 public:
  /// @param torque_rate Nm/s, of each joint
  JointLimitBarrier(const JointLimits& limits, double torque_rate) noexcept
      : limits_(limits), torque_rate_(torque_rate) {}

  /// How the joints move now.
  struct Motion {
    const ArmDynamics& dynamics;
    const OperationalSpace& space;  ///< built from the same inertia
    const JointVector& q;           ///< rad
    const JointVector& rate;        ///< rad/s; with elastic joints the faster of motor and link
    const JointVector& push;        ///< external torques, Nm
    bool touched;                   ///< the arm is in contact
  };
  /// The torques nearest to `tau` (Nm, gravity included) that keep the limits, as far as `range`
  /// lets them. Allocates nothing.
  [[nodiscard]] JointVector keep(const JointVector& tau, const TorqueRange& range,
                                 const Motion& motion, double dt) const noexcept;

 private:
  JointLimits limits_;
  double torque_rate_;
};

}  // namespace binpick
