#include <gtest/gtest.h>

#include <cmath>

#include "sim/world.h"
#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;
using testing::make_world;
using testing::step_for;

// The object between the pads, its model axes on the tool's: y along the jaws, z upward.
void hand_over(World& world, double opening, double height_in_object) {
  world.set_arm_position(world.shared().parts.scene.overview, opening);
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d T_world_tcp = world.T_world_tcp();
  T_world_object.linear().col(1) = T_world_tcp.linear().col(1);
  T_world_object.linear().col(2) = Eigen::Vector3d::UnitZ();
  T_world_object.linear().col(0) = T_world_object.linear().col(1).cross(Eigen::Vector3d::UnitZ());
  T_world_object.translation() =
      T_world_tcp.translation() - Eigen::Vector3d(0.0, 0.0, height_in_object);
  world.set_object_pose(0, T_world_object);
}

// Closes on the object while something else carries it.
void close_on_object(World& world, double force) {
  const Eigen::Isometry3d T = world.object_pose(0);
  world.set_gripper_command({0.0, 0.1, force});
  for (int i = 0; i < 1000; ++i) {
    if (!world.object_between_pads(0)) world.set_object_pose(0, T);
    world.step();
  }
}

TEST(Gripper, ClosesCompletelyOnNothing) {
  World world = make_world("single_bottle");
  world.park_object(0);
  world.set_gripper_command({0.0, 0.1, 40.0});
  step_for(world, 1.8);
  EXPECT_LT(world.sensors().gripper.width, world.shared().parts.gripper.closed_width);
}

TEST(Gripper, MovesAtTheCommandedSpeed) {
  World world = make_world("single_bottle");
  world.park_object(0);
  for (const double speed : {0.05, 0.2}) {
    world.set_arm_position(world.shared().parts.scene.overview, 0.15);
    world.set_gripper_command({0.02, speed, 40.0});
    step_for(world, 0.5);
    EXPECT_NEAR(world.sensors().gripper.width, 0.15 - 0.5 * speed, 0.005) << speed;
    step_for(world, 3.0);
    EXPECT_NEAR(world.sensors().gripper.width, 0.02, 5e-4) << speed;
  }
}

TEST(Gripper, JawsStayCentredUnderAOneSidedLoad) {
  World world = make_world("single_bottle");
  world.park_object(0);
  world.set_arm_position(world.shared().parts.scene.overview, 0.10);
  step_for(world, 0.3);
  const WorldIndex& index = world.shared().index;
  const int left = world.model().jnt_bodyid[world.model().dof_jntid[index.jaw_dof[0]]];
  world.set_body_force(left, 10.0 * world.T_world_tcp().linear().col(1));
  step_for(world, 1.0);
  const double q_left = world.data().qpos[index.jaw_qpos[0]];
  const double q_right = world.data().qpos[index.jaw_qpos[1]];
  EXPECT_LT(0.5 * std::abs(q_left - q_right), 2e-4);
  // Negative control: the load is there, the servo gives way by force over stiffness.
  EXPECT_GT(q_left + q_right, 0.10 + 1e-4);
}

class GripForce : public ::testing::TestWithParam<double> {};

TEST_P(GripForce, IsTheCommandedOneOnBothPads) {
  World world = make_world("single_rusk");
  hand_over(world, 0.155, 0.0);
  close_on_object(world, GetParam());
  const std::array<double, 2> forces = world.jaw_forces(0);
  EXPECT_NEAR(forces[0], GetParam(), 0.05 * GetParam());
  EXPECT_NEAR(forces[1], GetParam(), 0.05 * GetParam());
  EXPECT_NEAR(world.sensors().gripper.force, GetParam(), 0.05 * GetParam());
  EXPECT_NEAR(world.sensors().gripper.width, 0.145, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Gripper, GripForce, ::testing::Values(20.0, 40.0, 80.0));

TEST(Gripper, HoldsAHeavyBottleForTenSecondsWithoutSlip) {
  const auto shared = cell("single_bottle");
  PhysicsDraw draw = centre_physics(shared->parts.objects);
  draw.objects[0].mass = 1.1;
  World world(shared, draw);
  hand_over(world, 0.09, 0.0035);
  close_on_object(world, 40.0);
  ASSERT_TRUE(world.object_between_pads(0));
  const Eigen::Vector3d start = world.object_pose(0).translation();
  step_for(world, 10.0);
  EXPECT_TRUE(world.object_between_pads(0));
  EXPECT_LT((world.object_pose(0).translation() - start).norm(), 1e-3);
  // The bottle's weight, and nothing else, rests on the robot; the jaws' squeeze cancels.
  const Eigen::Vector3d weight(0.0, 0.0, -1.1 * 9.81);
  EXPECT_LT((world.contact_force_on_robot() - weight).norm(), 0.05);
}

TEST(Gripper, LosesWhatFrictionCannotHold) {
  const auto shared = cell("single_bottle");
  PhysicsDraw draw = centre_physics(shared->parts.objects);
  draw.objects[0].mass = 1.1;
  draw.objects[0].pad_friction = 0.05;
  World world(shared, draw);
  hand_over(world, 0.09, 0.0035);
  close_on_object(world, 40.0);
  step_for(world, 2.0);
  EXPECT_FALSE(world.object_between_pads(0));
}

}  // namespace
}  // namespace binpick
