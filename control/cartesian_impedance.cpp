#include "control/cartesian_impedance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "models/errors.h"

namespace binpick {
namespace {

/// The damping design needs some stiffness on every axis. A softer axis is damped as if it had
/// this much: 10 N/m, 1 Nm/rad.
const Vector6 kSoftestForDamping = (Vector6() << 10, 10, 10, 1, 1, 1).finished();

/// Energy that may be kept for raising the stiffness later, J.
constexpr double kEnergyStoreCapacity = 1.0;

/// The posture fades while the last of its energy is spent: this share.
constexpr double kPostureFade = 0.1;

/// A three-axis spring in series with a clutch that slips at `limit`: the Moreau envelope of
/// 1/2 e^T K e, whose gradient f has |f| <= limit. Slipping, all axes give way as if a compliance
/// `slip` had been added: f_i = k_i e_i / (1 + slip k_i) with |f| = limit.
struct ClippedSpring {
  ClippedSpring(const Eigen::Vector3d& k, const Eigen::Vector3d& e, double limit) noexcept {
    force = k.cwiseProduct(e);
    stretch = e;
    double norm = force.norm();
    if (norm > limit) {
      double slip = 0.0;
      // Newton on 1/|f|, which is nearly linear in the slip (as in trust-region methods): exact at
      // once for equal stiffnesses, monotone otherwise.
      for (int i = 0; i < 8 && norm > limit * (1.0 + 1e-9); ++i) {
        const Eigen::Vector3d softened = k.array() / (1.0 + slip * k.array());
        const double slope = force.cwiseAbs2().dot(softened);
        slip += (norm / limit - 1.0) * norm * norm / slope;
        force = k.array() * e.array() / (1.0 + slip * k.array());
        norm = force.norm();
      }
      stretch = e.array() / (1.0 + slip * k.array());
    }
    energy = 0.5 * force.dot(stretch) + limit * (e - stretch).norm();
  }

  Eigen::Vector3d force;
  Eigen::Vector3d stretch;
  double energy;
};

/// Moves a twist of the tool centre in world axes to the compliance centre in tool axes. Its
/// transpose moves a wrench back.
Matrix6 twist_transform(const Eigen::Matrix3d& R_world_target,
                        const Eigen::Vector3d& p_tcp_centre_world) noexcept {
  Eigen::Matrix3d lever;
  const Eigen::Vector3d& r = p_tcp_centre_world;
  lever << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  Matrix6 X = Matrix6::Zero();
  X.topLeftCorner<3, 3>() = R_world_target.transpose();
  X.bottomRightCorner<3, 3>() = R_world_target.transpose();
  X.topRightCorner<3, 3>() = -R_world_target.transpose().lazyProduct(lever);
  return X;
}

/// X A X^T for symmetric A and the upper block triangular X of twist_transform.
Matrix6 transformed(const Matrix6& X, const Matrix6& A) noexcept {
  const Matrix6 XA = X.lazyProduct(A);
  return XA.lazyProduct(X.transpose());
}

}  // namespace

void CartesianImpedanceOptions::validate() const {
  std::string problems;
  const auto require = [&problems](bool holds, const char* text) {
    if (!holds) problems += std::string(problems.empty() ? "" : "\n") + text;
  };
  require(stiffness.allFinite() && (stiffness.array() >= 0.0).all(),
          "Cartesian impedance: stiffnesses must not be negative");
  require(damping_ratio > 0.0, "Cartesian impedance: the damping ratio must be positive");
  require(p_tcp_compliance_centre.allFinite(),
          "Cartesian impedance: the compliance centre must be finite");
  require(max_spring_force > 0.0 && max_spring_torque > 0.0,
          "Cartesian impedance: the spring's limits must be positive");
  require(stiffness_ramp > 0.0, "Cartesian impedance: the stiffness ramp must take some time");
  require(posture_stiffness >= 0.0 && null_space_damping >= 0.0 && limit_stiffness >= 0.0 &&
              hard_limit_stiffness >= 0.0,
          "Cartesian impedance: null-space and limit gains must not be negative");
  require(posture_energy > 0.0, "Cartesian impedance: the posture needs some energy to act with");
  require(limit_margin >= 0.0 && hard_limit_margin >= 0.0,
          "Cartesian impedance: margins to the joint limits must not be negative");
  require(inertia_cap.mass > 0.0 && inertia_cap.inertia > 0.0,
          "Cartesian impedance: the inertia cap must be positive");
  require(joint_compliance.allFinite() && (joint_compliance.array() >= 0.0).all(),
          "Cartesian impedance: no joint's compliance may be negative");
  if (!problems.empty()) throw InputError(problems);
}

CartesianImpedance::CartesianImpedance(const JointLimits& limits,
                                       const CartesianImpedanceOptions& options)
    : options_(options),
      limits_(limits),
      requested_stiffness_(options.stiffness),
      stiffness_(options.stiffness),
      posture_store_(options.posture_energy) {
  options_.validate();
}

void CartesianImpedance::start(const JointVector& q) noexcept {
  stiffness_ = requested_stiffness_;
  posture_ = q;
  energy_store_ = 0.0;
  posture_store_ = options_.posture_energy;
  spring_wrench_.setZero();
  spring_energy_ = 0.0;
  damping_design_.reset();
}

CartesianImpedance::Spring CartesianImpedance::spring(
    const Eigen::Isometry3d& T_world_tcp, const Eigen::Isometry3d& T_world_target) const noexcept {
  const Eigen::Matrix3d R_target_world = T_world_target.linear().transpose();
  const Eigen::Matrix3d R_target_tcp = R_target_world.lazyProduct(T_world_tcp.linear());
  const Eigen::Vector3d& centre = options_.p_tcp_compliance_centre;
  const Eigen::Vector3d offset =
      R_target_world * (T_world_target.translation() - T_world_tcp.translation()) + centre -
      R_target_tcp * centre;
  const ClippedSpring translation(stiffness_.head<3>(), offset, options_.max_spring_force);

  // V = 2 eps^T K eps; of q and -q the nearer rotation is taken.
  Eigen::Quaterniond error(R_target_tcp);
  if (error.w() < 0.0) error.coeffs() = -error.coeffs();
  const Eigen::Vector3d eps = error.vec();
  const ClippedSpring rotation(stiffness_.tail<3>(), -2.0 * eps, options_.max_spring_torque);

  Spring result;
  result.wrench << translation.force, error.w() * rotation.force + eps.cross(rotation.force);
  result.stretch << translation.stretch, rotation.stretch;
  result.energy = translation.energy + rotation.energy;
  return result;
}

Matrix6 CartesianImpedance::damping_matrix(const ArmDynamics& dynamics,
                                           const OperationalSpace& space,
                                           const Matrix6& X) noexcept {
  const Vector6 stiffness = stiffness_.cwiseMax(kSoftestForDamping);
  const double zeta = options_.damping_ratio;
  const Vector6 cap = (Vector6() << Eigen::Vector3d::Constant(options_.inertia_cap.mass),
                       Eigen::Vector3d::Constant(options_.inertia_cap.inertia))
                          .finished();
  const Matrix6 D = damping_design_.from_inverse_inertia(
      stiffness, transformed(X, space.lambda_inverse()), zeta, cap);
  if (options_.joint_compliance.isZero(0.0)) return D;

  const Jacobian J = X.lazyProduct(dynamics.J);
  const Jacobian deflection = J * options_.joint_compliance.asDiagonal();
  const Matrix6 C = deflection.lazyProduct(J.transpose());
  Matrix6 lead = std::max(1.0 - zeta * zeta, 0.0) * C * stiffness.asDiagonal();
  lead.diagonal().array() += 1.0;
  const Matrix6 led = D.lazyProduct(lead);
  return lead.transpose().lazyProduct(led);
}

JointVector CartesianImpedance::torques(const ArmDynamics& dynamics, const OperationalSpace& space,
                                        const JointVector& q, const JointVector& qd,
                                        const CartesianTarget& target, double dt) noexcept {
  const Spring pull = spring(dynamics.T_world_tcp, target.T_world_tcp);
  const Matrix6 X =
      twist_transform(target.T_world_tcp.linear(),
                      dynamics.T_world_tcp.linear() * options_.p_tcp_compliance_centre);
  const Matrix6 D = damping_matrix(dynamics, space, X);

  const Vector6 twist = dynamics.J.lazyProduct(qd);
  const Vector6 lag_world = target.twist - twist;
  const Vector6 lag = X.lazyProduct(lag_world);
  const Vector6 damping = D.lazyProduct(lag);

  spring_energy_ = pull.energy;
  spring_wrench_ = X.transpose().lazyProduct(pull.wrench);
  Vector6 wrench = spring_wrench_;
  wrench += X.transpose().lazyProduct(damping);

  JointVector tau = hard_limit_torques(q);
  if (!target.twist.isZero(0.0) || !target.acceleration.isZero(0.0)) {
    const Vector6 momentum = space.lambda_times(twist);
    const double energy = twist.dot(momentum);
    const double planned_share =
        energy > 0.0 ? std::clamp(target.twist.dot(momentum) / energy, 0.0, 1.0) : 0.0;
    const Vector6 drift = dynamics.J_dot.lazyProduct(qd);
    wrench += space.lambda_times(target.acceleration - planned_share * drift);
    tau += planned_share * dynamics.coriolis;
  }
  tau += dynamics.J.transpose().lazyProduct(wrench);

  const double valve = std::min(posture_store_ / (kPostureFade * options_.posture_energy), 1.0);
  // Damping in proportion to momentum keeps tool and null space apart: its power is never positive.
  const JointVector null_space = space.null_space_part(
      valve * posture_torques(q) - options_.null_space_damping * dynamics.M.lazyProduct(qd));
  posture_store_ =
      std::clamp(posture_store_ - null_space.dot(qd) * dt, 0.0, options_.posture_energy);
  tau += null_space;

  ramp_stiffness(pull.stretch, lag.dot(damping), dt);
  return tau;
}

JointVector CartesianImpedance::static_torques(
    const ArmDynamics& dynamics, const OperationalSpace& space, const JointVector& q,
    const Eigen::Isometry3d& T_world_target) const noexcept {
  const Spring pull = spring(dynamics.T_world_tcp, T_world_target);
  const Matrix6 X = twist_transform(
      T_world_target.linear(), dynamics.T_world_tcp.linear() * options_.p_tcp_compliance_centre);
  const Vector6 wrench = X.transpose().lazyProduct(pull.wrench);
  const double valve = std::min(posture_store_ / (kPostureFade * options_.posture_energy), 1.0);
  JointVector tau = hard_limit_torques(q);
  tau += dynamics.J.transpose().lazyProduct(wrench);
  tau += space.null_space_part(valve * posture_torques(q));
  return tau;
}

void CartesianImpedance::ramp_stiffness(const Vector6& stretch, double dissipated_power,
                                        double dt) noexcept {
  energy_store_ = std::min(energy_store_ + dissipated_power * dt, kEnergyStoreCapacity);
  if (stiffness_ == requested_stiffness_) return;
  const Vector6 step = stiffness_.cwiseMax(requested_stiffness_) * (dt / options_.stiffness_ramp);
  // A spring that softens by dk gives back 1/2 dk x^2; one that stiffens costs as much.
  for (int i = 0; i < 6; ++i) {
    const double change = std::min(stiffness_[i] - requested_stiffness_[i], step[i]);
    if (change <= 0.0) continue;
    stiffness_[i] -= change;
    energy_store_ += 0.5 * change * stretch[i] * stretch[i];
  }
  for (int i = 0; i < 6; ++i) {
    double change = std::min(requested_stiffness_[i] - stiffness_[i], step[i]);
    if (change <= 0.0) continue;
    const double price = 0.5 * stretch[i] * stretch[i];
    if (change * price > energy_store_) change = energy_store_ / price;
    stiffness_[i] += change;
    energy_store_ -= change * price;
  }
}

JointVector CartesianImpedance::posture_torques(const JointVector& q) const noexcept {
  JointVector tau = options_.posture_stiffness * (posture_ - q);
  for (int i = 0; i < kArmJoints; ++i) {
    const double below = limits_.lower[i] + options_.limit_margin - q[i];
    const double above = q[i] - limits_.upper[i] + options_.limit_margin;
    if (below > 0.0) tau[i] += options_.limit_stiffness * below;
    if (above > 0.0) tau[i] -= options_.limit_stiffness * above;
  }
  return tau;
}

JointVector CartesianImpedance::hard_limit_torques(const JointVector& q) const noexcept {
  JointVector tau = JointVector::Zero();
  for (int i = 0; i < kArmJoints; ++i) {
    const double below = limits_.lower[i] + options_.hard_limit_margin - q[i];
    const double above = q[i] - limits_.upper[i] + options_.hard_limit_margin;
    if (below > 0.0) tau[i] += options_.hard_limit_stiffness * below;
    if (above > 0.0) tau[i] -= options_.hard_limit_stiffness * above;
  }
  return tau;
}

}  // namespace binpick
