#pragma once

#include "control/arm_model.h"
#include "models/gripper_description.h"
#include "models/random.h"
#include "models/robot_description.h"

namespace binpick::testing {

/// The arm of the repository with its gripper, standing at `T_world_base`.
inline ArmModel make_arm(const Eigen::Isometry3d& T_world_base = Eigen::Isometry3d::Identity()) {
  return ArmModel(load_lwr(), load_gripper(), T_world_base);
}

/// The arm with a tool of a milligram; its tool centre is the flange.
inline ArmModel make_bare_arm() {
  GripperDescription nothing;
  nothing.body.mass = 1e-6;
  return ArmModel(load_lwr(), nothing);
}

/// Uniform over the joint ranges, shrunk by `share` about their middles.
inline JointVector random_posture(Random& random, const JointLimits& limits, double share = 1.0) {
  JointVector q;
  for (int i = 0; i < kArmJoints; ++i) {
    const double middle = 0.5 * (limits.lower[i] + limits.upper[i]);
    const double half = 0.5 * (limits.upper[i] - limits.lower[i]);
    q[i] = middle + share * half * random.uniform(-1.0, 1.0);
  }
  return q;
}

/// Uniform in the cube [-size, size]^7.
inline JointVector random_vector(Random& random, double size) {
  JointVector v;
  for (int i = 0; i < kArmJoints; ++i) v[i] = random.uniform(-size, size);
  return v;
}

inline JointVector degrees(double q1, double q2, double q3, double q4, double q5, double q6,
                           double q7) {
  JointVector q;
  q << q1, q2, q3, q4, q5, q6, q7;
  return q * (3.14159265358979323846 / 180.0);
}

/// The rotation vector that turns `from` into `to`, world axes.
inline Eigen::Vector3d rotation_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to * from.transpose()));
  return turn.angle() * turn.axis();
}

}  // namespace binpick::testing
