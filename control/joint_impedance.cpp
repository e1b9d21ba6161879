#include "control/joint_impedance.h"

#include <fmt/format.h>

#include <algorithm>

#include "models/errors.h"

namespace binpick {

void JointImpedanceOptions::validate() const {
  std::string problems;
  if (!(stiffness.array() > 0.0).all() || !stiffness.allFinite()) {
    problems += "joint stiffness must be positive for every joint\n";
  }
  if (!(damping_ratio > 0.0)) problems += "joint damping ratio must be positive\n";
  if (!(max_spring_share > 0.0 && max_spring_share <= 1.0)) {
    problems += "the joint spring's share of the effort limit must lie in (0, 1]\n";
  }
  if (!problems.empty()) throw InputError("joint impedance: " + problems);
}

JointImpedance::JointImpedance(const JointLimits& limits, const JointImpedanceOptions& options)
    : options_(options), max_spring_torque_(options.max_spring_share * limits.effort) {
  options_.validate();
}

JointVector JointImpedance::torques(const ArmDynamics& dynamics, const JointVector& q,
                                    const JointVector& qd, const JointTarget& target) noexcept {
  const JointMatrix D =
      damping_design_.from_inertia(options_.stiffness, dynamics.M, options_.damping_ratio);
  const JointVector spring = static_torques(q, target.q);
  const JointVector momentum = dynamics.M.lazyProduct(qd);
  const double energy = qd.dot(momentum);
  const double planned_share =
      energy > 0.0 ? std::clamp(target.qd.dot(momentum) / energy, 0.0, 1.0) : 0.0;
  const JointVector velocity_error = target.qd - qd;
  JointVector tau = spring + planned_share * dynamics.coriolis;
  tau += D.lazyProduct(velocity_error);
  tau += dynamics.M.lazyProduct(target.qdd);
  return tau;
}

}  // namespace binpick
