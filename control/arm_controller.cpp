#include "control/arm_controller.h"

#include <algorithm>
#include <cmath>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr double kLongestPeriod = 0.1;  // s

// Beyond the speed that is allowed a joint is no longer driven on, over this share of its speed
// limit, and braked as if by a time constant of 10 ms. Both only take energy out.
constexpr double kSpeedFade = 0.1;
constexpr double kSpeedBrake = 100.0;  // 1/s
// Towards a position limit no joint may be faster than would take it there in this time, s.
constexpr double kLimitApproach = 0.03;

bool finite(const JointState& state) noexcept {
  return state.q.allFinite() && state.qd.allFinite() && state.tau.allFinite() &&
         state.theta.allFinite();
}

}  // namespace

void ArmControllerOptions::validate() const {
  cartesian.validate();
  joint.validate();
  observer.validate();
  limiter.validate();
  if (!(safe_stop_damping >= 0.0)) {
    throw InputError("arm controller: the safe stop's damping must not be negative");
  }
  if (!(max_target_speed > 0.0 && max_target_turn > 0.0)) {
    throw InputError("arm controller: the speeds of a set-point must be positive");
  }
}

ArmController::ArmController(const ArmModel& model, const ArmControllerOptions& options)
    : options_(options),
      unloaded_model_(model),
      model_(model),
      cartesian_(model.limits(), options.cartesian),
      joint_(model.limits(), options.joint),
      observer_(options.observer),
      monitor_(ContactThresholds::for_phase(ContactPhase::kFree, model.limits())),
      limiter_(model.limits(), options.limiter) {
  options_.validate();
  status_.dynamics = model_.evaluate(JointVector::Zero(), JointVector::Zero());
  status_.T_world_tcp = status_.dynamics.T_world_tcp;
}

void ArmController::enter(ControlMode mode) noexcept {
  if (mode_ == ControlMode::kSafeStop) return;
  if (mode_ != mode) starting_ = true;
  mode_ = mode;
  hold_ = false;
}

void ArmController::set_joint_target(const JointTarget& target) noexcept {
  joint_target_ = target;
  enter(ControlMode::kJoint);
}

void ArmController::set_cartesian_target(const CartesianTarget& target) noexcept {
  cartesian_target_ = target;
  enter(ControlMode::kCartesian);
}

void ArmController::set_stiffness(const Vector6& stiffness) noexcept {
  cartesian_.set_stiffness(stiffness);
}

void ArmController::set_posture(const JointVector& q) noexcept {
  posture_ = q;
  cartesian_.set_posture(q);
}

void ArmController::set_thresholds(const ContactThresholds& thresholds) noexcept {
  monitor_.set_thresholds(thresholds);
}

void ArmController::stop() noexcept { hold_ = true; }

void ArmController::set_payload(const BodyInertia& payload) {
  model_ = unloaded_model_.with_payload(payload);
  restart_observer();
}

void ArmController::clear_payload() noexcept {
  model_ = unloaded_model_;
  restart_observer();
}

void ArmController::zero_observer() noexcept { observer_.zero(); }

void ArmController::restart_observer() noexcept {
  observer_.reset();
  monitor_.reset();
}

void ArmController::reset() noexcept {
  mode_ = ControlMode::kJoint;
  status_.fault = ControlFault::kNone;
  starting_ = true;
  hold_ = true;
  restart_observer();
}

JointVector ArmController::tick(const JointState& state, double dt) noexcept {
  const bool good_period = dt > 0.0 && dt <= kLongestPeriod;
  if (!finite(state) || !good_period) {
    raise(good_period ? ControlFault::kBadState : ControlFault::kBadPeriod);
    // No velocity to brake against: hold with the gravity torques of the last good state.
    return safe_stop(JointVector::Zero(), good_period ? dt : kControlPeriod);
  }
  sense(state, dt);
  if (mode_ == ControlMode::kSafeStop) return safe_stop(state.qd, dt);
  if (hold_) hold_present_pose();

  const JointVector control = within_joint_limits(control_torques(dt));
  const std::optional<JointVector> tau = limiter_.limit(status_.dynamics.gravity, control, dt);
  if (!tau) {
    raise(ControlFault::kBadTarget);
    return safe_stop(state.qd, dt);
  }
  status_.mode = mode_;
  status_.torque_share = limiter_.share();
  return *tau;
}

void ArmController::sense(const JointState& state, double dt) noexcept {
  status_.q = state.q;
  status_.qd = state.qd;
  status_.dynamics = model_.evaluate(state.q, state.qd);
  status_.T_world_tcp = status_.dynamics.T_world_tcp;
  status_.twist = status_.dynamics.J.lazyProduct(state.qd);
  space_ = OperationalSpace(status_.dynamics.M, status_.dynamics.J, options_.cartesian.inertia_cap);

  observer_.update(status_.dynamics, state.qd, state.tau, dt);
  status_.residual = observer_.residual();
  status_.external_wrench = observer_.external_wrench(space_);
  monitor_.update(status_.external_wrench, status_.residual);
  status_.contact = monitor_.contact_class() != ContactClass::kNone;
  status_.collision = monitor_.hf1();
}

void ArmController::hold_present_pose() noexcept {
  joint_target_ = {.q = status_.q};
  cartesian_target_ = {.T_world_tcp = status_.T_world_tcp};
  q_equilibrium_ = status_.q;
  T_world_equilibrium_ = status_.T_world_tcp;
  hold_ = false;
}

void ArmController::start_law() noexcept {
  starting_ = false;
  q_equilibrium_ = status_.q;
  T_world_equilibrium_ = status_.T_world_tcp;
  joint_.reset();
  cartesian_.start(posture_.value_or(status_.q));
}

void ArmController::approach_target(double dt) noexcept {
  const double turn = options_.max_target_turn * dt;
  if (mode_ == ControlMode::kJoint) {
    q_equilibrium_ = joint_target_.q.cwiseMax(q_equilibrium_ - JointVector::Constant(turn))
                         .cwiseMin(q_equilibrium_ + JointVector::Constant(turn))
                         .eval();
    return;
  }
  const Eigen::Isometry3d& goal = cartesian_target_.T_world_tcp;
  Eigen::Isometry3d& now = T_world_equilibrium_;
  const Eigen::Vector3d way = goal.translation() - now.translation();
  const double distance = way.norm();
  const double travel = options_.max_target_speed * dt;
  if (distance > travel) {
    now.translation() += travel / distance * way;
  } else {
    now.translation() = goal.translation();
  }
  // 1 + 2 cos(angle between the two) is the sum of the entries' products.
  const double cosine = 0.5 * (now.linear().cwiseProduct(goal.linear()).sum() - 1.0);
  if (cosine < 1.0 - 0.5 * turn * turn) {
    const Eigen::AngleAxisd rotation(now.linear().transpose() * goal.linear());
    now.linear() = now.linear() * Eigen::AngleAxisd(turn, rotation.axis());
  } else {
    now.linear() = goal.linear();
  }
}

JointVector ArmController::control_torques(double dt) noexcept {
  if (starting_) start_law();
  approach_target(dt);
  if (mode_ == ControlMode::kJoint) {
    status_.spring_wrench.setZero();
    const JointTarget target{q_equilibrium_, joint_target_.qd, joint_target_.qdd};
    return joint_.torques(status_.dynamics, status_.q, status_.qd, target);
  }
  const CartesianTarget target{T_world_equilibrium_, cartesian_target_.twist,
                               cartesian_target_.acceleration};
  const JointVector tau =
      cartesian_.torques(status_.dynamics, space_, status_.q, status_.qd, target, dt);
  status_.spring_wrench = cartesian_.spring_wrench();
  return tau;
}

JointVector ArmController::within_joint_limits(JointVector control) const noexcept {
  const JointLimits& limits = model_.limits();
  for (int i = 0; i < kArmJoints; ++i) {
    const double q = status_.q[i];
    const double qd = status_.qd[i];
    const double room = qd > 0.0 ? limits.upper[i] - q : q - limits.lower[i];
    const double allowed = std::min(limits.velocity[i], std::max(room, 0.0) / kLimitApproach);
    const double excess = std::abs(qd) - allowed;
    if (excess <= 0.0) continue;
    if (control[i] * qd > 0.0) {
      control[i] *= std::max(0.0, 1.0 - excess / (kSpeedFade * limits.velocity[i]));
    }
    control[i] -= kSpeedBrake * status_.dynamics.M(i, i) * std::copysign(excess, qd);
  }
  return control;
}

void ArmController::raise(ControlFault fault) noexcept {
  if (mode_ == ControlMode::kSafeStop) return;
  mode_ = ControlMode::kSafeStop;
  status_.fault = fault;
  status_.torque_share = 1.0;
  status_.spring_wrench.setZero();
}

JointVector ArmController::safe_stop(const JointVector& qd, double dt) noexcept {
  status_.mode = mode_;
  const JointVector& gravity = status_.dynamics.gravity;
  const JointVector brake = -options_.safe_stop_damping * status_.dynamics.M.lazyProduct(qd);
  std::optional<JointVector> tau = limiter_.limit(gravity, brake, dt);
  if (!tau) tau = limiter_.limit(gravity, JointVector::Zero(), dt);
  return tau.value_or(JointVector::Zero());
}

}  // namespace binpick
