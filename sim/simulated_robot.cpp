#include "sim/simulated_robot.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "sim/simulation_error.h"

namespace binpick {

SimulatedRobot::SimulatedRobot(World& world, DepthCamera* camera, SimulatedRobotOptions options)
    : world_(world),
      camera_(camera),
      options_(std::move(options)),
      torque_noise_(derive_seed(options_.seed, "torque noise")),
      end_time_(world.time() + options_.time_budget) {
  Random offsets(derive_seed(options_.seed, "torque offset"));
  for (double& offset : torque_offset_) {
    offset = options_.sensor_noise.torque_offset * offsets.uniform(-1.0, 1.0);
  }
  world_.hold_arm(false);
  read_sensors();
}

RobotState SimulatedRobot::exchange(const RobotCommand& command) {
  const GripperCommand& gripper = command.gripper;
  if (!command.tau.allFinite() || !std::isfinite(gripper.width + gripper.speed + gripper.force)) {
    throw std::invalid_argument("a robot command must be finite");
  }
  if (world_.time() >= end_time_) {
    throw TimeBudgetSpent(
        fmt::format("the robot used up its {:.1f} s of simulated time", options_.time_budget));
  }
  world_.set_arm_torques(command.tau);
  world_.set_gripper_command(gripper);
  world_.step();
  read_sensors();
  if (options_.on_step) options_.on_step(world_);
  return state_;
}

RangeImage SimulatedRobot::capture() {
  if (camera_ == nullptr) throw std::logic_error("this robot was made without a camera");
  const Seed seed = derive_seed(derive_seed(options_.seed, "depth noise"), frames_++);
  return camera_->capture(world_, options_.camera_noise, seed);
}

void SimulatedRobot::read_sensors() {
  state_ = world_.sensors();
  state_.joints.tau += torque_offset_;
  if (options_.sensor_noise.torque_sigma > 0.0) {
    for (double& torque : state_.joints.tau) {
      torque += options_.sensor_noise.torque_sigma * torque_noise_.normal();
    }
  }
}

}  // namespace binpick
