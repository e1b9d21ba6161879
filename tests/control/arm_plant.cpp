#include "control/arm_plant.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace binpick {

ArmPlant::ArmPlant(const ArmModel& model, const JointVector& q)
    : model_(model), tau_(model.gravity(q)), sensed_(tau_) {
  now_ = {q, JointVector::Zero(), q, JointVector::Zero(), 0.0};
}

ArmPlant::ArmPlant(const ArmModel& model, const JointVector& q, const DriveDescription& drives,
                   Seed noise)
    : ArmPlant(model, q) {
  drives_ = drives;
  now_.theta = q + tau_.cwiseQuotient(drives.stiffness);
  noise_ = Random(derive_seed(noise, "torque sensors"));
  for (double& offset : sensor_offset_) {
    offset = drives.torque_offset * noise_.uniform(-1.0, 1.0);
  }
}

void ArmPlant::step(const JointVector& tau, const External& external, double dt, int substeps) {
  tau_ = tau;
  for (int i = 0; i < substeps; ++i) {
    substep(external, dt / substeps);
    read_sensors(dt / substeps);
  }
}

void ArmPlant::step(const JointVector& tau, double dt) { step(tau, nothing_outside(), dt); }

void ArmPlant::step_drives(const JointVector& tau, const JointTorqueLoop& loop,
                           const External& external) {
  if (!drives_) {
    step(tau, external);
    return;
  }
  constexpr double kPeriod = kControlPeriod / kTorqueLoopsPerControl;
  for (int i = 0; i < kTorqueLoopsPerControl; ++i) {
    step(loop(state(), tau, kPeriod), external, kPeriod, 2);
  }
}

JointState ArmPlant::state() const {
  if (!drives_) return {now_.q, now_.qd, tau_, now_.q, now_.qd};
  return {now_.q, now_.qd, sensed_ + sensor_offset_ + sensor_noise_, now_.theta, now_.theta_d};
}

ArmPlant::Motion ArmPlant::Motion::after(double h, const Motion& rate) const {
  return {q + h * rate.q, qd + h * rate.qd, theta + h * rate.theta, theta_d + h * rate.theta_d,
          work + h * rate.work};
}

JointVector ArmPlant::transmitted(const Motion& at) const {
  if (!drives_) return tau_;
  return drives_->stiffness.cwiseProduct(at.theta - at.q) +
         drives_->damping.cwiseProduct(at.theta_d - at.qd);
}

JointVector ArmPlant::sliding(const JointVector& motor_torque) const {
  JointVector direction;
  for (int i = 0; i < kArmJoints; ++i) {
    const double drive =
        std::abs(now_.theta_d[i]) > 0.0
            ? now_.theta_d[i]
            : motor_torque[i] * (std::abs(motor_torque[i]) > drives_->coulomb_friction[i]);
    direction[i] = static_cast<double>(drive > 0.0) - static_cast<double>(drive < 0.0);
  }
  return direction;
}

void ArmPlant::substep(const External& external, double h) {
  const JointVector slide =
      drives_ ? sliding(tau_ - transmitted(now_)) : JointVector(JointVector::Zero());
  const Motion r1 = rate(now_, slide, external);
  const Motion r2 = rate(now_.after(0.5 * h, r1), slide, external);
  const Motion r3 = rate(now_.after(0.5 * h, r2), slide, external);
  const Motion r4 = rate(now_.after(h, r3), slide, external);
  now_ = now_.after(h / 6.0, r1).after(h / 3.0, r2).after(h / 3.0, r3).after(h / 6.0, r4);
  work_ = now_.work;
  if (!drives_) return;
  for (int i = 0; i < kArmJoints; ++i) {
    const bool has_friction = drives_->coulomb_friction[i] > 0.0;
    if (has_friction && now_.theta_d[i] * slide[i] <= 0.0) now_.theta_d[i] = 0.0;
  }
}

ArmPlant::Motion ArmPlant::rate(const Motion& at, const JointVector& slide,
                                const External& external) const {
  const ArmDynamics dynamics = model_.evaluate(at.q, at.qd);
  const JointVector outside = external(dynamics, at.qd);
  const JointVector on_links = transmitted(at);
  const JointVector force = on_links + outside - dynamics.coriolis - dynamics.gravity;
  Motion result{at.qd, dynamics.M.llt().solve(force), at.theta_d, JointVector::Zero(),
                at.qd.dot(outside)};
  if (!drives_) return result;
  for (int i = 0; i < kArmJoints; ++i) {
    const double coulomb = drives_->coulomb_friction[i];
    const double free = tau_[i] - on_links[i] - drives_->viscous_friction[i] * at.theta_d[i];
    const double friction =
        slide[i] == 0.0 ? std::clamp(free, -coulomb, coulomb) : coulomb * slide[i];
    result.theta_d[i] = (free - friction) / drives_->motor_inertia[i];
  }
  return result;
}

void ArmPlant::read_sensors(double h) {
  if (!drives_) return;
  const JointVector spring = drives_->stiffness.cwiseProduct(now_.theta - now_.q);
  const double share = -std::expm1(-2.0 * std::numbers::pi * drives_->torque_bandwidth * h);
  sensed_ += share * (spring - sensed_);
  for (double& noise : sensor_noise_) noise = drives_->torque_noise * noise_.normal();
}

ArmPlant::External wrench_at_tool(const Vector6& wrench) {
  return [wrench](const ArmDynamics& dynamics, const JointVector&) {
    return JointVector(dynamics.J.transpose() * wrench);
  };
}

ArmPlant::External nothing_outside() {
  return [](const ArmDynamics&, const JointVector&) { return JointVector(JointVector::Zero()); };
}

ArmPlant::External wall(const Eigen::Vector3d& normal, double offset, double stiffness,
                        double damping) {
  return [=](const ArmDynamics& dynamics, const JointVector& qd) {
    const Eigen::Matrix<double, 1, kArmJoints> Jn = normal.transpose() * dynamics.J.topRows<3>();
    const double depth = offset - normal.dot(dynamics.T_world_tcp.translation());
    if (depth <= 0.0) return JointVector(JointVector::Zero());
    const double force = std::max(stiffness * depth - damping * Jn.dot(qd), 0.0);
    return JointVector(force * Jn.transpose());
  };
}

std::vector<JointVector> test_poses() {
  return {(JointVector() << 0.0, -0.5, 0.0, 1.5, 0.0, -1.14, 0.0).finished(),
          (JointVector() << 0.7, -0.7, 0.4, 1.3, -0.5, -0.9, 0.6).finished(),
          (JointVector() << -0.9, -0.3, -0.5, 1.6, 0.8, -0.8, -1.1).finished()};
}

std::vector<Vector6> table_one_stiffnesses() {
  std::vector<Vector6> all;
  for (const double k_ty : {200.0, 750.0, 2000.0}) {
    for (const double k_rx : {20.0, 75.0, 200.0}) {
      all.push_back((Vector6() << 2000, k_ty, 2000, k_rx, 200, 200).finished());
    }
  }
  return all;
}

}  // namespace binpick
