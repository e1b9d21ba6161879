#include "sim/simulated_robot.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "sim/simulation_error.h"

namespace binpick {
namespace {

JointVector drawn_within(double limit, Seed seed) {
  Random random(seed);
  JointVector values;
  for (double& value : values) value = limit * random.uniform(-1.0, 1.0);
  return values;
}

}  // namespace

SimulatedRobot::SimulatedRobot(World& world, DepthCamera* camera, SimulatedRobotOptions options)
    : world_(world),
      camera_(camera),
      options_(std::move(options)),
      torque_offset_(drawn_within(options_.sensor_noise.torque_offset,
                                  derive_seed(options_.seed, "torque offset"))),
      position_offset_(drawn_within(options_.sensor_noise.position_offset,
                                    derive_seed(options_.seed, "position offset"))),
      torque_noise_(derive_seed(options_.seed, "torque noise")),
      watch_(world.shared().parts.arm),
      end_time_(world.time() + options_.time_budget) {
  world_.hold_arm(false);
  if (world_.elastic()) {
    world_.set_torque_loop([this](const JointState& truth) { return motor_torques(truth); });
  }
  read_sensors();
}

SimulatedRobot::~SimulatedRobot() { world_.set_torque_loop({}); }

RobotState SimulatedRobot::exchange(const RobotCommand& command) {
  const GripperCommand& gripper = command.gripper;
  if (!command.tau.allFinite() || !std::isfinite(gripper.width + gripper.speed + gripper.force)) {
    throw std::invalid_argument("a robot command must be finite");
  }
  if (world_.time() >= end_time_) {
    throw TimeBudgetSpent(
        fmt::format("the robot used up its {:.1f} s of simulated time", options_.time_budget));
  }
  command_ = command.tau;
  world_.set_arm_torques(command_);
  world_.set_gripper_command({gripper.width + options_.jaw_offset, gripper.speed, gripper.force});
  world_.step();
  read_sensors();
  if (options_.on_step) options_.on_step(world_);
  if (options_.watched) watch_over(command_);
  return state_;
}

void SimulatedRobot::watch_over(const JointVector& tau) {
  const auto finding = watch_.check(tau, world_.sensors().joints, state_.joints);
  if (!finding) return;
  world_.hold_arm(true);
  throw RobotStopped(fmt::format("t = {:.3f} s: {}: brakes closed", world_.time(), *finding));
}

JointVector SimulatedRobot::motor_torques(const JointState& truth) {
  if (!options_.torque_loop) return command_;
  const double period = kControlPeriod / kTorqueLoopsPerControl;
  const JointVector tau = options_.torque_loop(measured(truth), command_, period);
  return tau.allFinite() ? tau : command_;
}

RangeImage SimulatedRobot::capture() {
  if (camera_ == nullptr) throw std::logic_error("this robot was made without a camera");
  const Seed seed = derive_seed(derive_seed(options_.seed, "depth noise"), frames_++);
  return camera_->capture(world_, options_.camera_noise, seed);
}

JointState SimulatedRobot::measured(const JointState& truth) {
  JointState joints = truth;
  joints.tau += torque_offset_;
  joints.q += position_offset_;
  joints.theta += position_offset_;
  if (options_.sensor_noise.torque_sigma > 0.0) {
    for (double& torque : joints.tau) {
      torque += options_.sensor_noise.torque_sigma * torque_noise_.normal();
    }
  }
  const auto& fault = options_.fault;
  if (!fault || world_.time() < fault->start) return joints;
  if (!before_fault_) before_fault_ = joints;
  const int i = fault->joint;
  switch (fault->kind) {
    case SensorFault::Kind::kPositionNan:
      joints.q[i] = joints.theta[i] = std::numeric_limits<double>::quiet_NaN();
      break;
    case SensorFault::Kind::kTorqueNan:
      joints.tau[i] = std::numeric_limits<double>::quiet_NaN();
      break;
    case SensorFault::Kind::kFrozen:
      joints.q[i] = before_fault_->q[i];
      joints.qd[i] = before_fault_->qd[i];
      joints.tau[i] = before_fault_->tau[i];
      joints.theta[i] = before_fault_->theta[i];
      joints.theta_d[i] = before_fault_->theta_d[i];
      break;
  }
  return joints;
}

void SimulatedRobot::read_sensors() {
  RobotState now = world_.sensors();
  now.joints = measured(now.joints);
  now.gripper.width -= options_.jaw_offset;
  in_flight_.push_back(now);
  state_ = in_flight_.front();
  if (in_flight_.size() > static_cast<std::size_t>(options_.latency)) in_flight_.pop_front();
}

}  // namespace binpick
