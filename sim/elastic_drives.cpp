#include "sim/elastic_drives.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace binpick {

void ElasticDrives::reset(const JointVector& q, const JointVector& tau) {
  theta_ = q + tau.cwiseQuotient(drives_.stiffness);
  theta_d_.setZero();
  sensed_ = tau;
  tau_motor_ = tau;
  lead_ = 0.0;
}

void ElasticDrives::advance(Motor& motor, int joint, double q, double qd, double time,
                            double h) const noexcept {
  const double K = drives_.stiffness[joint];
  const double D = drives_.damping[joint];
  const auto link_at = [&](double t) { return Line{q + std::min(t, 0.0) * qd, std::max(t, 0.0)}; };
  const Line link = link_at(time);
  const Line next_link = link_at(time + h);
  const Line velocity = time + 0.4 * h > 0.0 ? Line{0.0, 1.0} : Line{qd, 0.0};

  const Line spring{K * (motor.theta.base - link.base), K * (motor.theta.slope - link.slope)};
  // (B + h D + h v) theta_d_end = momentum - h c sgn(theta_d_end) + h D qd_link
  const double B = drives_.motor_inertia[joint];
  const double inertia = B + h * D + h * drives_.viscous_friction[joint];
  const Line momentum{
      B * motor.theta_d.base + h * (tau_motor_[joint] - spring.base + D * velocity.base),
      B * motor.theta_d.slope + h * (D * velocity.slope - spring.slope)};
  const double to_stop = momentum.at(qd);
  const double friction = h * drives_.coulomb_friction[joint];
  if (std::abs(to_stop) <= friction) {
    motor.theta_d = {0.0, 0.0};
  } else {
    motor.theta_d = {(momentum.base - std::copysign(friction, to_stop)) / inertia,
                     momentum.slope / inertia};
  }
  motor.impulse.base += h * (spring.base + D * (motor.theta_d.base - velocity.base));
  motor.impulse.slope += h * (spring.slope + D * (motor.theta_d.slope - velocity.slope));
  motor.theta.base += h * motor.theta_d.base;
  motor.theta.slope += h * motor.theta_d.slope;

  const double smoothing = -std::expm1(-2.0 * std::numbers::pi * drives_.torque_bandwidth * h);
  const Line read{K * (motor.theta.base - next_link.base),
                  K * (motor.theta.slope - next_link.slope)};
  motor.sensed.base += smoothing * (read.base - motor.sensed.base);
  motor.sensed.slope += smoothing * (read.slope - motor.sensed.slope);
}

ElasticDrives::Coupling ElasticDrives::begin_step(const JointVector& q, const JointVector& qd,
                                                  double duration, int short_steps,
                                                  const TorqueLoop& loop) {
  const double h = duration / short_steps;
  lead_ = 0.5 * (duration - h);
  for (int i = 0; i < kArmJoints; ++i) {
    motors_[std::size_t(i)] = {{theta_[i], 0.0}, {theta_d_[i], 0.0}, {sensed_[i], 0.0}, {}};
  }
  for (int step = 0; step < short_steps; ++step) {
    const double time = step * h - lead_;
    if (loop) {
      JointState state{.q = q + time * qd, .qd = qd};
      for (int i = 0; i < kArmJoints; ++i) {
        const Motor& motor = motors_[std::size_t(i)];
        state.tau[i] = motor.sensed.at(qd[i]);
        state.theta[i] = motor.theta.at(qd[i]);
        state.theta_d[i] = motor.theta_d.at(qd[i]);
      }
      tau_motor_ = loop(state);
    }
    for (int i = 0; i < kArmJoints; ++i) {
      advance(motors_[std::size_t(i)], i, q[i], qd[i], time, h);
    }
  }
  Coupling coupling;
  for (int i = 0; i < kArmJoints; ++i) {
    // The mean torque is base + slope qd_1, and qd_1 = qd + H qdd.
    const Line& impulse = motors_[std::size_t(i)].impulse;
    coupling.torque[i] = impulse.at(qd[i]) / duration;
    coupling.armature[i] = -impulse.slope;
  }
  return coupling;
}

void ElasticDrives::end_step(const JointVector& qd) {
  for (int i = 0; i < kArmJoints; ++i) {
    const Motor& motor = motors_[std::size_t(i)];
    theta_[i] = motor.theta.at(qd[i]);
    theta_d_[i] = motor.theta_d.at(qd[i]);
    sensed_[i] = motor.sensed.at(qd[i]);
  }
}

}  // namespace binpick
