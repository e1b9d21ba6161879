#include "sim/simulated_robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "sim/simulation_error.h"
#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;
using testing::make_world;

TEST(SimulatedRobot, ExchangeLetsOneMillisecondPass) {
  World world = make_world("single_bottle");
  int steps = 0;
  SimulatedRobotOptions options;
  options.on_step = [&](World&) { ++steps; };
  SimulatedRobot robot(world, nullptr, options);
  RobotCommand command;
  command.tau = world.balancing_torques();
  for (int i = 0; i < 5; ++i) robot.exchange(command);
  EXPECT_NEAR(world.time(), 5 * kControlPeriod, 1e-12);
  EXPECT_EQ(steps, 5);
  EXPECT_EQ(robot.state().joints.q, world.sensors().joints.q);
}

TEST(SimulatedRobot, SpentTimeBudgetThrows) {
  World world = make_world("single_bottle");
  SimulatedRobotOptions options;
  options.time_budget = 0.0095;
  SimulatedRobot robot(world, nullptr, options);
  for (int i = 0; i < 10; ++i) robot.exchange({});
  EXPECT_THROW(robot.exchange({}), TimeBudgetSpent);
}

TEST(SimulatedRobot, CommandsThatAreNotFiniteAreRefused) {
  World world = make_world("single_bottle");
  SimulatedRobot robot(world, nullptr, {});
  RobotCommand command;
  command.tau[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(robot.exchange(command), std::invalid_argument);
  command = {};
  command.gripper.width = std::numeric_limits<double>::infinity();
  EXPECT_THROW(robot.exchange(command), std::invalid_argument);
}

TEST(SimulatedRobot, WrongZerosStayAndShiftBothSidesOfAJoint) {
  constexpr double kOffset = 0.002;
  World world = make_world("single_bottle");
  SimulatedRobotOptions options;
  options.sensor_noise.position_offset = kOffset;
  options.watched = false;  // the arm falls
  SimulatedRobot robot(world, nullptr, options);
  const auto errors = [&] {
    const JointState read = robot.state().joints;
    const JointState truth = world.sensors().joints;
    EXPECT_TRUE((read.theta - truth.theta).isApprox(read.q - truth.q, 1e-9));
    EXPECT_EQ(read.qd, truth.qd);
    return JointVector(read.q - truth.q);
  };
  const JointVector first = errors();
  EXPECT_LE(first.cwiseAbs().maxCoeff(), kOffset);
  EXPECT_GT(first.cwiseAbs().minCoeff(), 0.0);
  EXPECT_NE(first[0], first[1]);
  for (int i = 0; i < 100; ++i) robot.exchange({});
  EXPECT_TRUE(errors().isApprox(first, 1e-9));
}

TEST(SimulatedRobot, JawsStandFurtherApartThanTheyReadByTheirOffset) {
  constexpr double kOffset = 0.003;
  World world = make_world("single_bottle");
  SimulatedRobotOptions options;
  options.jaw_offset = kOffset;
  options.watched = false;  // the arm falls
  SimulatedRobot robot(world, nullptr, options);
  RobotCommand command;
  command.gripper = {.width = 0.08, .speed = 0.4, .force = 40.0};
  for (int i = 0; i < 500; ++i) robot.exchange(command);
  EXPECT_NEAR(robot.state().gripper.width, 0.08, 5e-4);
  EXPECT_NEAR(world.sensors().gripper.width, 0.08 + kOffset, 5e-4);
}

TEST(SimulatedRobot, SensorNoiseHasTheStatedSizeAndSeed) {
  World world = make_world("single_bottle");
  SimulatedRobotOptions options;
  options.sensor_noise = {0.05, 0.3};
  options.watched = false;  // the arm falls
  options.seed = 3;
  SimulatedRobot robot(world, nullptr, options);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kSteps = 2000;
  for (int i = 0; i < kSteps; ++i) {
    const double error = robot.exchange({}).joints.tau[0] - world.sensors().joints.tau[0];
    sum += error;
    squares += error * error;
  }
  const double mean = sum / kSteps;
  EXPECT_LE(std::abs(mean), 0.31);
  EXPECT_GT(std::abs(mean), 1e-3);
  EXPECT_NEAR(std::sqrt(squares / kSteps - mean * mean), 0.05, 0.005);
}

TEST(SimulatedRobot, LatencyDelaysWhatTheBrainSees) {
  World prompt_world = make_world("single_bottle");
  World late_world = make_world("single_bottle");
  SimulatedRobot prompt(prompt_world, nullptr, {});
  SimulatedRobotOptions options;
  options.latency = 2;
  SimulatedRobot late(late_world, nullptr, options);
  RobotCommand command;
  command.tau = prompt_world.balancing_torques() + JointVector::Constant(0.3);
  std::vector<JointVector> history{prompt.state().joints.q, prompt.state().joints.q};
  for (int i = 0; i < 20; ++i) {
    history.push_back(prompt.exchange(command).joints.q);
    EXPECT_EQ(late.exchange(command).joints.q, history[history.size() - 3]) << i;
  }
}

class FailingSensor : public ::testing::TestWithParam<std::pair<SensorFault::Kind, const char*>> {};

TEST_P(FailingSensor, ClosesTheBrakesAndSaysWhich) {
  World world = make_world("single_bottle");
  world.park_object(0);
  SimulatedRobotOptions options;
  options.fault = SensorFault{GetParam().first, 2, 0.2};
  SimulatedRobot robot(world, nullptr, options);
  // Joint 3 turns at 0.6 rad/s, by a servo that knows the truth.
  JointVector speed = JointVector::Zero();
  speed[2] = 0.6;
  std::string message;
  try {
    for (int i = 0; i < 600; ++i) {
      RobotCommand command;
      command.tau = world.balancing_torques() + speed - world.sensors().joints.qd;
      robot.exchange(command);
    }
  } catch (const RobotStopped& stopped) {
    message = stopped.what();
  }
  EXPECT_THAT(message, ::testing::HasSubstr("joint 3"));
  EXPECT_THAT(message, ::testing::HasSubstr(GetParam().second));
  EXPECT_GT(world.time(), 0.2);
  const JointVector q = world.sensors().joints.q;
  testing::step_for(world, 0.5);
  EXPECT_EQ(world.sensors().joints.q, q);
}

INSTANTIATE_TEST_SUITE_P(
    SimulatedRobot, FailingSensor,
    ::testing::Values(std::pair(SensorFault::Kind::kPositionNan, "position sensor delivers no"),
                      std::pair(SensorFault::Kind::kTorqueNan, "torque sensor delivers no"),
                      std::pair(SensorFault::Kind::kFrozen, "sensors differ")));

TEST(SimulatedRobot, DrivesFallBackToTheCommandWhenTheirTorqueLoopFails) {
  const auto shared = cell("single_bottle");
  World world(shared, centre_physics(shared->parts.objects), load_lwr_drives());
  world.park_object(0);
  SimulatedRobotOptions options;
  int calls = 0;
  options.torque_loop = [&](const JointState&, const JointVector& tau, double) {
    ++calls;
    return JointVector(tau * std::numeric_limits<double>::quiet_NaN());
  };
  SimulatedRobot robot(world, nullptr, options);
  RobotCommand command;
  command.tau = world.balancing_torques();
  const JointVector q = robot.state().joints.q;
  for (int i = 0; i < 500; ++i) robot.exchange(command);
  EXPECT_EQ(calls, 1500);
  EXPECT_LT((robot.state().joints.q - q).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(SimulatedRobot, EveryFrameHasItsOwnNoise) {
  const auto shared = cell("single_bottle");
  DepthCamera camera(shared);
  const auto two_frames = [&](Seed seed) {
    World world(shared, centre_physics(shared->parts.objects));
    SimulatedRobotOptions options;
    options.seed = seed;
    SimulatedRobot robot(world, &camera, options);
    return std::pair(robot.capture().depth, robot.capture().depth);
  };
  const auto [first, second] = two_frames(1);
  EXPECT_EQ(first, two_frames(1).first);
  EXPECT_NE(first, second);
  EXPECT_NE(first, two_frames(2).first);
}

}  // namespace
}  // namespace binpick
