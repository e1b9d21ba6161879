#include "control/elastic_joints.h"

#include <cmath>

#include "models/errors.h"

namespace binpick {

ElasticJoints ElasticJoints::of(const DriveDescription& drives) noexcept {
  ElasticJoints joints;
  joints.stiffness = drives.stiffness;
  joints.damping = drives.damping;
  joints.motor_inertia = drives.motor_inertia;
  return joints;
}

void ElasticJoints::validate() const {
  std::string problems;
  const auto positive = [](const JointVector& v) {
    return v.allFinite() && (v.array() > 0.0).all();
  };
  if (!positive(stiffness)) problems += "the stiffness of every joint must be positive\n";
  if (!positive(motor_inertia)) problems += "every motor's inertia must be positive\n";
  if (!damping.allFinite() || (damping.array() < 0.0).any()) {
    problems += "no joint's damping may be negative\n";
  }
  if (!(inertia_reduction >= 1.0) || !std::isfinite(inertia_reduction)) {
    problems += "torque feedback must not make the motors heavier: a reduction of 1 or more\n";
  }
  if (!(inertia_cap.mass > 0.0 && inertia_cap.inertia > 0.0)) {
    problems += "the inertia cap must be positive\n";
  }
  if (!problems.empty()) throw InputError("elastic joints: " + problems);
}

TorqueFeedback::TorqueFeedback(const ElasticJoints& joints)
    : reduction_(joints.inertia_reduction), damping_(joints.damping) {
  joints.validate();
}

JointVector TorqueFeedback::motor_torques(const JointState& state,
                                          const JointVector& u) const noexcept {
  const JointVector transmitted =
      state.tau - sensor_offset_ + damping_.cwiseProduct(state.theta_d - state.qd);
  return reduction_ * u + (1.0 - reduction_) * transmitted;
}

JointTorqueLoop TorqueFeedback::loop() const {
  return [this](const JointState& state, const JointVector& u, double) {
    return motor_torques(state, u);
  };
}

}  // namespace binpick
