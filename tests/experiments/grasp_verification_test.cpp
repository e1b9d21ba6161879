// The strategy's verification, by jaw width and load, in physics.

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "vision_cell_support.h"

namespace binpick {
namespace {

using testing::VisionBench;

/// A bottle in front of the robot, and a robot that believes it is turned by `believed_yaw`.
class GraspVerification : public ::testing::Test {
 protected:
  GraspPlan plan(double believed_yaw) {
    Detection detection;
    detection.model = "bottle";
    detection.T_scene_model = bench_.world.object_pose(0);
    detection.T_scene_model.rotate(Eigen::AngleAxisd(believed_yaw, Eigen::Vector3d::UnitZ()));
    for (GraspPlan& candidate : bench_.knowledge.selector().feasible_grasps(detection)) {
      if (candidate.grasp->name == "top across wide axis") return candidate;
    }
    throw std::logic_error("no such grasp");
  }

  RobotSkills skills(bool verification) {
    SkillOptions options;
    options.strategy.verification = verification;
    return bench_.knowledge.make_skills(robot_, nullptr, options);
  }

  /// Between the jaws as before, but after lifting all but weightless.
  SkillResult carry_what_becomes_light(bool verification) {
    RobotSkills lifting = skills(verification);
    const GraspPlan grasp = plan(0.0);
    if (lifting.grasp(grasp) != SkillResult::kDone) throw std::logic_error("not lifted");
    const double mass = centre_physics(bench_.shared->parts.objects).objects.front().mass;
    bench_.world.set_body_force(bench_.shared->index.object_body[0], {0.0, 0.0, 9.0 * mass});
    const Place& place = bench_.knowledge.layout().places.front();
    return lifting.carry(grasp, place, place.slots.front());
  }

  VisionBench bench_{load_scene(BINPICK_SOURCE_DIR "/scenes/single_bottle.yaml"), {"bottle"}};
  SimulatedRobot robot_{bench_.world, &bench_.camera, {}};
};

constexpr double kQuarterTurn = std::numbers::pi / 2.0;

TEST_F(GraspVerification, WhatIsHeldAsPlannedIsCarriedOn) {
  RobotSkills careful = skills(true);
  EXPECT_EQ(careful.grasp(plan(0.0)), SkillResult::kDone);
}

TEST_F(GraspVerification, AnotherWidthThanThePlannedOneIsNoticedAndPutBackGently) {
  RobotSkills careful = skills(true);
  EXPECT_EQ(careful.grasp(plan(kQuarterTurn)), SkillResult::kFailedGrasp);
  const Eigen::Isometry3d T_world_bottle = bench_.world.object_pose(0);
  EXPECT_GT(T_world_bottle.linear()(2, 2), 0.98) << "it stands again";
}

TEST_F(GraspVerification, WithoutItTheWrongWidthGoesUnnoticed) {
  RobotSkills trusting = skills(false);
  EXPECT_EQ(trusting.grasp(plan(kQuarterTurn)), SkillResult::kDone);
}

TEST_F(GraspVerification, ALoadThatIsGoneIsMissedBeforePlacing) {
  EXPECT_EQ(carry_what_becomes_light(true), SkillResult::kSlipped);
}

TEST_F(GraspVerification, AnArmThatIsOffStillFeelsTheLightestBottle) {
  PhysicsDraw light = centre_physics(bench_.shared->parts.objects);
  light.objects.front().mass = bench_.shared->parts.objects.front().physics.mass.low;
  for (Seed seed = 0; seed < 3; ++seed) {
    World world(bench_.shared, light);
    SimulatedRobotOptions off;
    off.sensor_noise = {.torque_offset = 0.3, .position_offset = 0.0017};
    off.jaw_offset = 0.001;
    off.seed = seed;
    SimulatedRobot robot(world, nullptr, off);
    SkillOptions options;
    options.strategy.verification = true;
    RobotSkills careful = bench_.knowledge.make_skills(robot, nullptr, options);
    careful.go_to_overview();
    const GraspPlan grasp = plan(0.0);
    ASSERT_EQ(careful.grasp(grasp), SkillResult::kDone) << seed;
    const Place& place = bench_.knowledge.layout().places.front();
    EXPECT_EQ(careful.carry(grasp, place, place.slots.front()), SkillResult::kDone) << seed;
  }
}

TEST_F(GraspVerification, WithoutItALoadThatIsGoneGoesUnnoticed) {
  EXPECT_EQ(carry_what_becomes_light(false), SkillResult::kDone);
}

}  // namespace
}  // namespace binpick
