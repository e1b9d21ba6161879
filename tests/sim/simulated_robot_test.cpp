#include "sim/simulated_robot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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
