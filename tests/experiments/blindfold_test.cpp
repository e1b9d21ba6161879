// The robot's brain sees images and joint states, never the truth: what it cannot have seen, it
// cannot act on.

#include <gmock/gmock.h>

#include "vision_cell_support.h"

namespace binpick {
namespace {

using testing::MischievousRobot;
using testing::scene_with;
using testing::standing;
using testing::VisionBench;

SimulatedRobotOptions quiet() {
  SimulatedRobotOptions options;
  options.time_budget = 120.0;
  return options;
}

std::vector<AutomatonEvent> events_in(const AutomatonResult& result, AutomatonState state) {
  std::vector<AutomatonEvent> events;
  for (const AutomatonEvent& event : result.events) {
    if (event.state == state) events.push_back(event);
  }
  return events;
}

AutomatonResult run_automaton(VisionBench& bench, Robot& robot, int max_attempts) {
  RecognizerPerception perception(bench.recognizer, 5);
  RobotSkills skills = bench.knowledge.make_skills(robot, &perception, {});
  AutomatonOptions options;
  options.max_attempts = max_attempts;
  options.looks_before_empty = 1;
  ManipulationAutomaton automaton(skills, bench.knowledge.selector(), bench.knowledge.layout(),
                                  bench.knowledge.objects(), options);
  return automaton.run();
}

TEST(Blindfold, AnObjectLeftWhereItWasSeenIsGrasped) {
  VisionBench bench(scene_with({standing("amicelli", 0.55, -0.05)}), {"amicelli"});
  SimulatedRobot simulated(bench.world, &bench.camera, quiet());
  const AutomatonResult result = run_automaton(bench, simulated, 1);
  EXPECT_EQ(result.placed, 1);
}

TEST(Blindfold, AnObjectMovedAfterTheImageIsMissedAtItsNewPlace) {
  VisionBench bench(scene_with({standing("amicelli", 0.55, -0.05)}), {"amicelli"});
  SimulatedRobot simulated(bench.world, &bench.camera, quiet());
  const Eigen::Isometry3d moved = Eigen::Translation3d(0.0, 0.17, 0.0) * bench.world.object_pose(0);
  MischievousRobot robot(simulated, [&] { bench.world.set_object_pose(0, moved); });

  const AutomatonResult result = run_automaton(bench, robot, 1);
  EXPECT_EQ(result.placed, 0);
  const auto grasps = events_in(result, AutomatonState::kGraspObject);
  ASSERT_EQ(grasps.size(), 1u);
  EXPECT_TRUE(grasps.front().conditions.failed_grasp) << grasps.front().detail;
  EXPECT_LT((bench.world.object_pose(0).translation() - moved.translation()).norm(), 0.01);
}

TEST(Blindfold, AnObjectThatTheLibraryLacksIsNeverGraspedOnPurpose) {
  VisionBench bench(scene_with({standing("bottle", 0.55, 0.1), standing("rusk", 0.55, -0.12)}),
                    {"rusk"});
  SimulatedRobot simulated(bench.world, &bench.camera, quiet());
  const Eigen::Vector3d before = bench.world.object_pose(0).translation();

  const AutomatonResult result = run_automaton(bench, simulated, 0);
  EXPECT_EQ(result.reason, HaltReason::kBelievedEmpty);
  EXPECT_EQ(result.placed, 1);
  for (const AutomatonEvent& event : events_in(result, AutomatonState::kGraspObject)) {
    EXPECT_EQ(event.object, "rusk");
  }
  EXPECT_LT((bench.world.object_pose(0).translation() - before).norm(), 0.01);
}

}  // namespace
}  // namespace binpick
