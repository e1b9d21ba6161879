#include "sim/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "models/random.h"
#include "sim/simulation_error.h"
#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;
using testing::make_world;
using testing::step_for;

constexpr double kGravity = 9.81;

// A run with everything in motion: the arm falls, the jaws close, the object is pushed.
WorldState eventful_run(World& world, int steps) {
  world.hold_arm(false);
  world.set_arm_torques(JointVector::Constant(3.0));
  world.set_gripper_command({0.02, 0.1, 30.0});
  world.set_body_force(world.shared().index.object_body[0], {0.5, 0.2, 0.0});
  for (int i = 0; i < steps; ++i) world.step();
  return world.save_state();
}

TEST(World, SameStartGivesSameBytesOnAnyThread) {
  World here = make_world("blind_bottle");
  const WorldState reference = eventful_run(here, 400);
  WorldState elsewhere;
  std::thread([&] {
    World world = make_world("blind_bottle");
    elsewhere = eventful_run(world, 400);
  }).join();
  EXPECT_EQ(reference.numbers, elsewhere.numbers);
  EXPECT_EQ(reference.time, elsewhere.time);
}

TEST(World, RestoredStateContinuesBitForBit) {
  World world = make_world("blind_bottle");
  const WorldState middle = eventful_run(world, 150);
  for (int i = 0; i < 200; ++i) world.step();
  const WorldState end = world.save_state();
  World other = make_world("blind_bottle");
  step_for(other, 0.05);
  other.restore_state(middle);
  for (int i = 0; i < 200; ++i) other.step();
  EXPECT_EQ(end.numbers, other.save_state().numbers);
  EXPECT_EQ(end.time, other.time());
}

TEST(World, StatesOfOtherTemplatesAreRefused) {
  World world = make_world("blind_bottle");
  EXPECT_THROW(world.restore_state(make_world("pile").save_state()), std::invalid_argument);
}

class Divergence : public ::testing::TestWithParam<double> {};

TEST_P(Divergence, IsThrownInsteadOfASilentReset) {
  World world = make_world("blind_bottle");
  step_for(world, 0.01);
  world.mutable_data().qvel[world.shared().index.object_dof[0]] = GetParam();
  EXPECT_THROW(step_for(world, 0.01), SimulationDiverged);
}

INSTANTIATE_TEST_SUITE_P(World, Divergence,
                         ::testing::Values(1e12, std::numeric_limits<double>::quiet_NaN(),
                                           std::numeric_limits<double>::infinity()));

TEST(World, ErrorsOfMujocoAreThrown) {
  const World world = make_world("blind_bottle");
  EXPECT_THROW(mju_error("planted"), SimulationDiverged);
}

TEST(World, FullContactBufferIsThrown) {
  World world = make_world("single_rusk");
  world.mutable_data().warning[mjWARN_CONTACTFULL].number = 1;
  EXPECT_THROW(world.step(), SimulationDiverged);
}

class StandingObject : public ::testing::TestWithParam<const char*> {};

TEST_P(StandingObject, StandsStill) {
  World world = make_world(GetParam());
  const Eigen::Isometry3d before = world.object_pose(0);
  step_for(world, 2.0);
  const Eigen::Isometry3d moved = before.inverse() * world.object_pose(0);
  EXPECT_LT(moved.translation().norm(), 2e-4);
  EXPECT_LT(Eigen::AngleAxisd(moved.linear()).angle(), 2e-3);
  EXPECT_LT(world.object_velocity(0).norm(), 1e-4);
  EXPECT_LT(std::abs(world.object_lowest_point(0)), 2e-4);
  EXPECT_TRUE(world.object_supported(0));
}

INSTANTIATE_TEST_SUITE_P(World, StandingObject,
                         ::testing::Values("single_bottle", "single_amicelli", "single_rusk"));

TEST(World, ObjectsFallWithGravity) {
  World world = make_world("single_rusk");
  Eigen::Isometry3d T = world.object_pose(0);
  T.translation().z() += 0.6;
  world.set_object_pose(0, T);
  step_for(world, 0.3);
  EXPECT_NEAR(T.translation().z() - world.object_pose(0).translation().z(),
              0.5 * kGravity * 0.3 * 0.3, 2e-3);
  EXPECT_FALSE(world.object_supported(0));
}

// Coulomb on the table: held below mu m g, and above it accelerated by what is left.
TEST(World, TableFrictionIsTheTrialsOwn) {
  for (const double friction : {0.2, 0.45}) {
    const auto shared = cell("single_rusk");
    PhysicsDraw draw = centre_physics(shared->parts.objects);
    draw.objects[0].table_friction = friction;
    World world(shared, draw);
    step_for(world, 0.2);
    const double limit = friction * draw.objects[0].mass * kGravity;
    const double start = world.object_pose(0).translation().x();
    const int body = shared->index.object_body[0];
    world.set_body_force(body, {0.9 * limit, 0.0, 0.0});
    step_for(world, 0.5);
    EXPECT_NEAR(world.object_pose(0).translation().x(), start, 2e-4) << friction;
    world.set_body_force(body, {1.5 * limit, 0.0, 0.0});
    step_for(world, 0.3);
    const double expected = 0.5 * friction * kGravity * 0.3;
    EXPECT_NEAR(world.object_velocity(0).x(), expected, 0.05 * expected) << friction;
  }
}

TEST(World, PhysicsOfTheTrialIsEntered) {
  const auto shared = cell("pile");
  const PhysicsDraw draw = draw_physics(shared->parts.objects, 7);
  const World world(shared, draw);
  for (std::size_t i = 0; i < draw.objects.size(); ++i) {
    const ObjectPhysics& ranges = shared->parts.objects[i].physics;
    EXPECT_TRUE(ranges.mass.contains(draw.objects[i].mass));
    EXPECT_TRUE(ranges.pad_friction.contains(draw.objects[i].pad_friction));
    const int body = shared->index.object_body[i];
    EXPECT_NEAR(world.model().body_mass[body], draw.objects[i].mass, 1e-12);
    const double traced = world.model().body_inertia[3 * body] +
                          world.model().body_inertia[3 * body + 1] +
                          world.model().body_inertia[3 * body + 2];
    EXPECT_NEAR(traced, draw.objects[i].mass * ranges.inertia_per_mass.trace(), 1e-9);
  }
  EXPECT_NE(draw.objects[0].mass, draw_physics(shared->parts.objects, 8).objects[0].mass);
  EXPECT_NE(draw.objects[0].mass, draw.objects[1].mass);
}

TEST(World, BalancingTorquesHoldTheFreeArm) {
  World world = make_world("single_rusk");
  const JointVector start = world.sensors().joints.q;
  world.hold_arm(false);
  for (int i = 0; i < 1000; ++i) {
    world.set_arm_torques(world.balancing_torques());
    world.step();
  }
  EXPECT_LT((world.sensors().joints.q - start).cwiseAbs().maxCoeff(), 1e-6);
  world.set_arm_torques(JointVector::Zero());
  step_for(world, 0.2);
  EXPECT_GT((world.sensors().joints.q - start).cwiseAbs().maxCoeff(), 0.05);
}

// Gravity torques from the description alone: every link and the tool as a point at its centre of
// mass, tau = -sum J^T m g by finite differences of the potential energy.
TEST(World, GravityTorquesAreTheGradientOfThePotential) {
  World world = make_world("single_rusk");
  const auto potential = [&](const JointVector& q) {
    world.set_arm_position(q, 0.08);
    double energy = 0.0;
    const auto& model = world.model();
    for (int body = 1; body < model.nbody; ++body) {
      if (world.shared().index.object_body[0] == body) continue;
      energy += model.body_mass[body] * kGravity * world.data().xipos[3 * body + 2];
    }
    return energy;
  };
  Random random(11);
  for (int pose = 0; pose < 5; ++pose) {
    JointVector q;
    for (double& angle : q) angle = random.uniform(-1.5, 1.5);
    JointVector gradient;
    for (Eigen::Index i = 0; i < kArmJoints; ++i) {
      JointVector plus = q;
      JointVector minus = q;
      plus[i] += 1e-5;
      minus[i] -= 1e-5;
      gradient[i] = (potential(plus) - potential(minus)) / 2e-5;
    }
    world.set_arm_position(q, 0.08);
    EXPECT_LT((world.balancing_torques() - gradient).cwiseAbs().maxCoeff(), 1e-5);
  }
}

// What a sensor between drive and link reads is the component along the axis of the force that
// passes through the joint, which MuJoCo finds from the accelerations of all outer links.
TEST(World, TorqueSensorReadsTheForceThroughTheJoint) {
  World world = make_world("single_rusk");
  world.hold_arm(false);
  Random random(5);
  for (int step = 0; step < 50; ++step) {
    JointVector applied = world.balancing_torques();
    for (double& torque : applied) torque += random.uniform(-2.0, 2.0);
    world.set_arm_torques(applied);
    mjData& data = world.mutable_data();
    const std::vector<mjtNum> velocity(data.qvel, data.qvel + world.model().nv);
    world.step();
    const JointVector read = world.sensors().joints.tau;
    EXPECT_LT((read - applied).cwiseAbs().maxCoeff(), 1e-12);
    // The accelerations belong to the velocities before the step.
    std::copy(velocity.begin(), velocity.end(), data.qvel);
    mj_rnePostConstraint(&world.model(), &data);
    for (std::size_t i = 0; i < kArmJoints; ++i) {
      const int dof = world.shared().index.arm_dof[i];
      const int body = world.model().dof_bodyid[dof];
      const Eigen::Map<const Eigen::Matrix<double, 6, 1>> axis(world.data().cdof + 6 * dof);
      const Eigen::Map<const Eigen::Matrix<double, 6, 1>> force(world.data().cfrc_int + 6 * body);
      EXPECT_NEAR(axis.dot(force), read[Eigen::Index(i)], 1e-6) << "joint " << i + 1;
    }
  }
}

TEST(World, TorquesAreLimitedToTheEfforts) {
  World world = make_world("single_rusk");
  world.hold_arm(false);
  world.set_arm_torques(JointVector::Constant(1e4));
  world.step();
  for (Eigen::Index i = 0; i < kArmJoints; ++i) {
    EXPECT_NEAR(world.sensors().joints.tau[i],
                world.shared().parts.arm.joints[std::size_t(i)].effort, 1e-9);
  }
}

TEST(World, HeldArmStaysExactlyWhereItIs) {
  World world = make_world("single_rusk");
  const JointVector start = world.sensors().joints.q;
  world.set_arm_torques(JointVector::Constant(20.0));
  step_for(world, 0.2);
  EXPECT_EQ(world.sensors().joints.q, start);
}

TEST(World, ToolCentreFollowsTheDescription) {
  World world = make_world("single_rusk");
  world.set_arm_position(JointVector::Zero(), 0.1);
  const WorldParts& parts = world.shared().parts;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (const JointDescription& joint : parts.arm.joints) T = T * joint.T_parent_joint;
  T = T * parts.arm.T_link7_flange * parts.gripper.T_flange_tcp;
  EXPECT_TRUE(world.T_world_tcp().isApprox(T, 1e-9));
}

TEST(World, ParkedObjectsTouchNothingAndStay) {
  World world = make_world("single_bottle");
  world.park_object(0);
  step_for(world, 0.5);
  EXPECT_TRUE(world.object_parked(0));
  EXPECT_GT(world.object_pose(0).translation().z(), 10.0);
  EXPECT_EQ(world.data().ncon, 0);
}

}  // namespace
}  // namespace binpick
