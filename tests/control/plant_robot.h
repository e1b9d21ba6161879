#pragma once

#include <stdexcept>
#include <utility>

#include "control/arm_plant.h"
#include "models/robot.h"

namespace binpick {

/// A robot for tests of what drives robots: the plant behind the boundary, jaws that go where they
/// are told at once, no camera.
class PlantRobot final : public Robot {
 public:
  explicit PlantRobot(ArmPlant plant, ArmPlant::External external = nothing_outside())
      : plant_(std::move(plant)), external_(std::move(external)) {}

  [[nodiscard]] RobotState state() const override { return {plant_.state(), gripper_}; }
  RobotState exchange(const RobotCommand& command) override {
    plant_.step_drives(command.tau, loop_, external_);
    gripper_.width = command.gripper.width;
    return state();
  }
  [[nodiscard]] RangeImage capture() override { throw std::logic_error("no camera"); }

  void set_torque_loop(JointTorqueLoop loop) { loop_ = std::move(loop); }
  void set_external(ArmPlant::External external) { external_ = std::move(external); }
  [[nodiscard]] const ArmPlant& plant() const { return plant_; }

 private:
  ArmPlant plant_;
  ArmPlant::External external_;
  JointTorqueLoop loop_;
  GripperState gripper_;
};

}  // namespace binpick
