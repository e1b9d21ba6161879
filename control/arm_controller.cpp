#include "control/arm_controller.h"

#include <algorithm>
#include <cmath>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr double kLongestPeriod = 0.1;  // s

// Fixed-point steps towards qb per tick, which go on from the last tick's; each takes out at least
// three quarters of the error (the Cartesian stiffness against that of the joints).
constexpr int kStaticSteps = 2;
constexpr int kFirstStaticSteps = 12;
// A virtual spring that pulls with this share of its limit is wound up.
constexpr double kWoundUp = 0.25;

bool finite(const JointState& state) noexcept {
  return state.q.allFinite() && state.qd.allFinite() && state.tau.allFinite() &&
         state.theta.allFinite() && state.theta_d.allFinite();
}

CartesianImpedanceOptions cartesian_options(const ArmControllerOptions& options) {
  CartesianImpedanceOptions cartesian = options.cartesian;
  if (options.joints) {
    cartesian.inertia_cap = options.joints->inertia_cap;
    cartesian.joint_compliance = options.joints->stiffness.cwiseInverse();
  }
  return cartesian;
}

}  // namespace

void ArmControllerOptions::validate() const {
  cartesian.validate();
  joint.validate();
  observer.validate();
  limiter.validate();
  if (joints) joints->validate();
  if (!(safe_stop_damping >= 0.0)) {
    throw InputError("arm controller: the safe stop's damping must not be negative");
  }
  if (!(floating_damping >= 0.0)) {
    throw InputError("arm controller: the damping while floating must not be negative");
  }
  if (!(max_target_speed > 0.0 && max_target_turn > 0.0 && max_target_joint_speed > 0.0)) {
    throw InputError("arm controller: the speeds of a set-point must be positive");
  }
}

ArmController::ArmController(const ArmModel& model, const ArmControllerOptions& options)
    : options_(options),
      unloaded_model_(model),
      model_(model),
      cartesian_(model.limits(), cartesian_options(options)),
      joint_(model.limits(), options.joint),
      observer_(options.observer),
      monitor_(ContactThresholds::for_phase(ContactPhase::kFree, model.limits())),
      limiter_(model.limits(), options.limiter),
      barrier_(model.limits(), options.limiter.rate) {
  options_.validate();
  status_.dynamics = model_.evaluate(JointVector::Zero(), JointVector::Zero());
  status_.T_world_tcp = status_.dynamics.T_world_tcp;
  motors_.dynamics = status_.dynamics;
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

void ArmController::stop() noexcept {
  if (mode_ == ControlMode::kFloating) enter(ControlMode::kJoint);
  hold_ = true;
}

void ArmController::float_freely() noexcept { enter(ControlMode::kFloating); }

void ArmController::set_payload(const BodyInertia& payload) {
  model_ = unloaded_model_.with_payload(payload);
  restart_observer();
}

void ArmController::clear_payload() noexcept {
  model_ = unloaded_model_;
  restart_observer();
}

void ArmController::set_sensor_offset(const JointVector& offset) noexcept {
  sensor_offset_ = offset;
  restart_observer();
}

void ArmController::zero_observer() noexcept {
  set_sensor_offset(sensor_offset_ - observer_.residual());
}

void ArmController::restart_observer() noexcept {
  motors_.known = false;
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
  if (options_.joints) sense_motors(state);
  if (mode_ == ControlMode::kSafeStop) return safe_stop(qd(), dt);
  if (hold_) hold_present_pose();

  const std::optional<JointVector> limited =
      limiter_.limit(dynamics().gravity, control_torques(dt), dt);
  if (!limited) {
    raise(ControlFault::kBadTarget);
    return safe_stop(qd(), dt);
  }
  const JointVector tau = within_joint_limits(*limited, dt);
  limiter_.start(tau);
  status_.mode = mode_;
  status_.torque_share = limiter_.share();
  return tau;
}

void ArmController::sense(const JointState& state, double dt) noexcept {
  status_.q = state.q;
  status_.qd = state.qd;
  status_.dynamics = model_.evaluate(state.q, state.qd);
  status_.T_world_tcp = status_.dynamics.T_world_tcp;
  status_.twist = status_.dynamics.J.lazyProduct(state.qd);
  space_ = OperationalSpace(status_.dynamics.M, status_.dynamics.J, options_.cartesian.inertia_cap);

  JointVector transmitted = state.tau - sensor_offset_;
  if (options_.joints) {
    transmitted += options_.joints->damping.cwiseProduct(state.theta_d - state.qd);
  }
  observer_.update(status_.dynamics, state.qd, transmitted, dt);
  status_.residual = observer_.residual();
  status_.external_wrench = observer_.external_wrench(space_);
  monitor_.update(status_.external_wrench, status_.residual);
  status_.contact = monitor_.contact_class() != ContactClass::kNone;
  status_.collision = monitor_.hf1();
}

void ArmController::sense_motors(const JointState& state) noexcept {
  const ElasticJoints& joints = *options_.joints;
  motors_.qd = state.theta_d;
  if (!motors_.known) motors_.load = status_.dynamics.gravity;
  const int steps = motors_.known ? kStaticSteps : kFirstStaticSteps;
  motors_.known = true;
  for (int i = 0; i < steps; ++i) {
    motors_.q = state.theta - motors_.load.cwiseQuotient(joints.stiffness);
    motors_.dynamics = model_.evaluate(motors_.q, motors_.qd);
    motors_.dynamics.M.diagonal() += joints.shaped_inertia();
    motors_.space = OperationalSpace(motors_.dynamics.M, motors_.dynamics.J, joints.inertia_cap);
    motors_.load = static_torques();
  }
}

JointVector ArmController::static_torques() const noexcept {
  JointVector tau = dynamics().gravity;
  if (hold_ || starting_) return tau;
  if (mode_ == ControlMode::kJoint) {
    tau += joint_.static_torques(q(), q_equilibrium_);
  } else if (mode_ == ControlMode::kCartesian) {
    tau += cartesian_.static_torques(dynamics(), space(), q(), T_world_equilibrium_);
  }
  return tau;
}

void ArmController::hold_present_pose() noexcept {
  joint_target_ = {.q = q()};
  cartesian_target_ = {.T_world_tcp = dynamics().T_world_tcp};
  q_equilibrium_ = q();
  T_world_equilibrium_ = dynamics().T_world_tcp;
  hold_ = false;
}

void ArmController::start_law() noexcept {
  starting_ = false;
  q_equilibrium_ = q();
  T_world_equilibrium_ = dynamics().T_world_tcp;
  joint_.reset();
  cartesian_.start(posture_.value_or(q()));
}

void ArmController::approach_target(double dt) noexcept {
  if (mode_ == ControlMode::kJoint) {
    approach_joint_target(dt);
  } else {
    approach_cartesian_target(dt);
  }
}

void ArmController::approach_joint_target(double dt) noexcept {
  const JointVector way = joint_target_.q - q_equilibrium_;
  if (!(way.cwiseAbs().maxCoeff() > options_.max_target_turn * dt)) {
    q_equilibrium_ = joint_target_.q;
    return;
  }
  const JointVector step = (options_.max_target_joint_speed * model_.limits().velocity)
                               .cwiseMin(options_.max_target_turn) *
                           dt;
  q_equilibrium_ += way.cwiseMax(-step).cwiseMin(step);
}

void ArmController::approach_cartesian_target(double dt) noexcept {
  const Eigen::Isometry3d& goal = cartesian_target_.T_world_tcp;
  Eigen::Isometry3d& now = T_world_equilibrium_;
  const Eigen::Vector3d way = goal.translation() - now.translation();
  const double distance = way.norm();
  const double travel = options_.max_target_speed * dt;
  const double turn = options_.max_target_turn * dt;
  // 1 + 2 cos(angle between the two) is the sum of the entries' products.
  const double cosine = 0.5 * (now.linear().cwiseProduct(goal.linear()).sum() - 1.0);
  const bool far = distance > travel || cosine < 1.0 - 0.5 * turn * turn;
  if (!far) {
    now = goal;
    return;
  }
  // What the arm does not follow is waited for: a spring that is wound up to its limit would hurl
  // the tool once it comes free.
  const Vector6& spring = cartesian_.spring_wrench();
  if (spring.head<3>().norm() > kWoundUp * options_.cartesian.max_spring_force ||
      spring.tail<3>().norm() > kWoundUp * options_.cartesian.max_spring_torque) {
    return;
  }
  const Eigen::AngleAxisd rotation(goal.linear() * now.linear().transpose());
  Vector6 step;
  step << way * std::min(1.0, travel / std::max(distance, travel)),
      rotation.axis() * std::min(rotation.angle(), turn);
  const JointVector joint_step = space().joint_velocity_of(step);
  const JointVector allowed = options_.max_target_joint_speed * dt * model_.limits().velocity;
  const double excess = joint_step.cwiseAbs().cwiseQuotient(allowed).maxCoeff();
  if (excess > 1.0) step /= excess;
  now.translation() += step.head<3>();
  const double angle = step.tail<3>().norm();
  if (angle > 0.0) {
    const Eigen::Vector3d axis = step.tail<3>() / angle;
    now.linear() = Eigen::AngleAxisd(angle, axis) * now.linear();
  }
}

JointVector ArmController::control_torques(double dt) noexcept {
  if (starting_) start_law();
  if (mode_ == ControlMode::kFloating) {
    status_.spring_wrench.setZero();
    return -options_.floating_damping * dynamics().M.lazyProduct(qd());
  }
  approach_target(dt);
  if (mode_ == ControlMode::kJoint) {
    status_.spring_wrench.setZero();
    const JointTarget target{q_equilibrium_, joint_target_.qd, joint_target_.qdd};
    return joint_.torques(dynamics(), q(), qd(), target);
  }
  const CartesianTarget target{T_world_equilibrium_, cartesian_target_.twist,
                               cartesian_target_.acceleration};
  const JointVector tau = cartesian_.torques(dynamics(), space(), q(), qd(), target, dt);
  status_.spring_wrench = cartesian_.spring_wrench();
  return tau;
}

JointVector ArmController::within_joint_limits(const JointVector& tau, double dt) const noexcept {
  JointVector rate = qd();
  if (options_.joints) {
    for (int i = 0; i < kArmJoints; ++i) {
      if (std::abs(status_.qd[i]) > std::abs(rate[i])) rate[i] = status_.qd[i];
    }
  }
  return barrier_.keep(tau, limiter_.range(),
                       {dynamics(), space(), q(), rate, observer_.unfiltered(), status_.contact},
                       dt);
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
  const JointVector& gravity = dynamics().gravity;
  const JointVector brake = -options_.safe_stop_damping * dynamics().M.lazyProduct(qd);
  std::optional<JointVector> tau = limiter_.limit(gravity, brake, dt);
  if (!tau) tau = limiter_.limit(gravity, JointVector::Zero(), dt);
  return tau.value_or(JointVector::Zero());
}

}  // namespace binpick
