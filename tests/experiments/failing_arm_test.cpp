// What the brain and the simulated robot together make of failing sensors and of latency.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "control/manipulator.h"
#include "experiments/arm_plant.h"
#include "models/robot_description.h"
#include "sim/simulation_error.h"
#include "sim/world.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

constexpr double kFailure = 0.3;  // s: in the middle of the motion

/// How a motion of 0.15 m downward at 0.25 m/s in an empty cell ended.
struct Ending {
  std::string said;  ///< by the robot's safety; empty: it did not stop the arm
  ControlFault fault = ControlFault::kNone;
  double moved_after_failure = 0.0;  ///< by the tool until the robot said it, m
  double error = 0.0;                ///< of the tool at the end, m
  double end = 0.0;                  ///< s
};

Ending come_down(const std::string& joints, SimulatedRobotOptions options) {
  const ArmPlant plant({joints, 1.0, true});
  const auto shared =
      make_world_template(load_scene(BINPICK_SOURCE_DIR "/scenes/blind_bottle.yaml"));
  World world(shared, centre_physics(shared->parts.objects), plant.drives());
  world.park_object(0);
  Ending ending;
  Eigen::Vector3d p_failure = Eigen::Vector3d::Zero();
  options.on_step = [&](World& now) {
    if (now.time() < kFailure) p_failure = now.T_world_tcp().translation();
  };
  plant.configure(options);
  options.sensor_noise.torque_offset = 0.0;
  SimulatedRobot robot(world, nullptr, options);
  ArmControllerOptions controller;
  plant.configure(controller);
  Manipulator manipulator(robot, ArmModel(load_lwr(), load_gripper()), controller);
  const Eigen::Isometry3d goal = Eigen::Translation3d(0.0, 0.0, -0.15) * world.T_world_tcp();
  const MotionStops on{.on_collision = false};
  try {
    manipulator.hold(0.1, on);
    manipulator.move_line(goal, CartesianMotionLimits::at_speed(0.25), on);
    manipulator.hold(1.0, on);
  } catch (const RobotStopped& stopped) {
    ending.said = stopped.what();
  }
  ending.fault = manipulator.controller().status().fault;
  const Eigen::Vector3d p_end = world.T_world_tcp().translation();
  ending.moved_after_failure = (p_end - p_failure).norm();
  ending.error = (p_end - goal.translation()).norm();
  ending.end = world.time();
  return ending;
}

class FailingArm : public ::testing::TestWithParam<std::tuple<std::string, SensorFault::Kind>> {};

TEST_P(FailingArm, ComesToRestAndSaysWhy) {
  const auto& [joints, kind] = GetParam();
  SimulatedRobotOptions options;
  options.fault = SensorFault{kind, 3, kFailure};
  const Ending ending = come_down(joints, options);
  EXPECT_THAT(ending.said, HasSubstr("joint 4"));
  EXPECT_THAT(ending.said, HasSubstr("sensor"));
  EXPECT_THAT(ending.said, HasSubstr("brakes closed"));
  if (kind != SensorFault::Kind::kFrozen) {
    EXPECT_EQ(ending.fault, ControlFault::kBadState);  // the brain saw it first
    EXPECT_LT(ending.end, kFailure + SafetyWatch::kPatience + 0.005);
  }
  EXPECT_LT(ending.moved_after_failure, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Sensors, FailingArm,
                         ::testing::Combine(::testing::Values("rigid", "elastic"),
                                            ::testing::Values(SensorFault::Kind::kPositionNan,
                                                              SensorFault::Kind::kTorqueNan,
                                                              SensorFault::Kind::kFrozen)));

class LateArm : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(LateArm, StillArrives) {
  const auto& [joints, latency] = GetParam();
  SimulatedRobotOptions options;
  options.latency = latency;
  const Ending ending = come_down(joints, options);
  EXPECT_EQ(ending.said, "");
  EXPECT_EQ(ending.fault, ControlFault::kNone);
  // Motor friction leaves the elastic arm within J^-T tau_f / 4 of its goal.
  EXPECT_LT(ending.error, joints == "rigid" ? 0.001 : 0.01);
}

INSTANTIATE_TEST_SUITE_P(Latency, LateArm,
                         ::testing::Combine(::testing::Values("rigid", "elastic"),
                                            ::testing::Values(0, 1)));

}  // namespace
}  // namespace binpick
