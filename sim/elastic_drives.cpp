#include "sim/elastic_drives.h"

#include <cmath>
#include <numbers>

namespace binpick {

void ElasticDrives::reset(const JointVector& q, const JointVector& tau) {
  theta_ = q + tau.cwiseQuotient(drives_.stiffness);
  theta_d_.setZero();
  sensed_ = tau;
  tau_motor_ = tau;
}

ElasticDrives::Coupling ElasticDrives::begin_step(const JointVector& q, const JointVector& qd,
                                                  double h) {
  h_ = h;
  Coupling coupling;
  for (int i = 0; i < kArmJoints; ++i) {
    const double spring = drives_.stiffness[i] * (theta_[i] - q[i]);
    const double damper = h * drives_.damping[i];  // impulse per velocity difference
    // (B + h D + h v) theta_d_end = momentum - h c sgn(theta_d_end) + h D qd_end
    const double inertia = drives_.motor_inertia[i] + damper + h * drives_.viscous_friction[i];
    const double momentum = drives_.motor_inertia[i] * theta_d_[i] + h * (tau_motor_[i] - spring);
    const double to_stop = momentum + damper * qd[i];
    const double friction = h * drives_.coulomb_friction[i];
    MotorStep& step = step_[static_cast<std::size_t>(i)];
    if (std::abs(to_stop) <= friction) {
      step = {0.0, 0.0};
    } else {
      step = {(momentum - std::copysign(friction, to_stop)) / inertia, damper / inertia};
    }
    // tau_t = spring + D (base + (share - 1) qd_end), and qd_end = qd + h qdd.
    coupling.torque[i] = spring + drives_.damping[i] * (step.base + (step.share - 1.0) * qd[i]);
    coupling.armature[i] = damper * (1.0 - step.share);
  }
  return coupling;
}

void ElasticDrives::end_step(const JointVector& q, const JointVector& qd) {
  const double smoothing = -std::expm1(-2.0 * std::numbers::pi * drives_.torque_bandwidth * h_);
  for (int i = 0; i < kArmJoints; ++i) {
    const MotorStep& step = step_[static_cast<std::size_t>(i)];
    theta_d_[i] = step.base + step.share * qd[i];
    theta_[i] += h_ * theta_d_[i];
    sensed_[i] += smoothing * (drives_.stiffness[i] * (theta_[i] - q[i]) - sensed_[i]);
  }
}

}  // namespace binpick
