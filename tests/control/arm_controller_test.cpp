#include "control/arm_controller.h"

#include <gtest/gtest.h>

#include <cmath>

#include "control/controlled_arm.h"
#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

TEST(ArmController, HoldsTheFirstPoseUntilTold) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    ControlledArm arm(model, pose);
    arm.run(0.5);
    EXPECT_LT((arm.plant.q() - pose).norm(), 1e-6);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kJoint);
    EXPECT_FALSE(arm.controller.status().contact);
  }
}

TEST(ArmController, SwitchesLawsWithoutABump) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ControlledArm arm(model, pose);
  const Eigen::Vector3d start = model.forward_kinematics(pose).translation();
  arm.run(0.2);
  for (int i = 0; i < 4; ++i) {
    arm.controller.set_cartesian_target({.T_world_tcp = arm.controller.status().T_world_tcp});
    arm.run(0.2);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kCartesian);
    arm.controller.set_joint_target({.q = arm.controller.status().q});
    arm.run(0.2);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kJoint);
  }
  EXPECT_LT((model.forward_kinematics(arm.plant.q()).translation() - start).norm(), 1e-4);
  EXPECT_LT(arm.largest_step, 0.1);
}

TEST(ArmController, StopCancelsTheSpringAndEndsTheMotion) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ControlledArm arm(model, pose);
  CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
  far.T_world_tcp.translation().x() += 0.3;
  arm.controller.set_cartesian_target(far);
  arm.run(0.15);
  EXPECT_GT(arm.controller.status().spring_wrench.head<3>().norm(), 10.0);
  arm.controller.stop();
  arm.tick();
  EXPECT_LT(arm.controller.status().spring_wrench.norm(), 1e-6);
  const Eigen::Vector3d stopped_at = arm.controller.status().T_world_tcp.translation();
  arm.run(2.0);
  EXPECT_LT(arm.plant.qd().norm(), 1e-3);
  EXPECT_LT((arm.controller.status().T_world_tcp.translation() - stopped_at).norm(), 2e-3);
}

TEST(ArmController, PayloadIsCarriedOnceItIsKnown) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  BodyInertia bottle;
  bottle.mass = 1.1;
  bottle.com = Eigen::Vector3d(0, 0, 0.05);
  bottle.inertia = Eigen::Vector3d(0.008, 0.008, 0.001).asDiagonal();
  ControlledArm arm(model, model.with_payload(bottle), pose);
  arm.controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(pose)});
  arm.run(1.0);
  EXPECT_NEAR(arm.controller.status().external_wrench.z(), -1.1 * 9.81, 0.3);
  EXPECT_TRUE(arm.controller.status().contact);

  arm.controller.set_payload(bottle);
  arm.controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(pose)});
  arm.run(1.0);
  EXPECT_LT(arm.controller.status().external_wrench.norm(), 0.05);
  EXPECT_FALSE(arm.controller.status().contact);
  const Eigen::Vector3d sag = arm.controller.status().T_world_tcp.translation() -
                              model.forward_kinematics(pose).translation();
  EXPECT_LT(sag.norm(), 1e-4);
}

TEST(ArmController, ZeroingTakesSensorOffsetsAway) {
  const ArmModel model = testing::make_arm();
  ArmController controller(model);
  const JointVector pose = test_poses()[1];
  JointState state{.q = pose, .tau = model.gravity(pose), .theta = pose};
  state.tau += JointVector::Constant(0.3);
  for (int i = 0; i < 500; ++i) (void)controller.tick(state, kControlPeriod);
  EXPECT_NEAR(controller.status().residual[3], -0.3, 1e-3);
  controller.zero_observer();
  (void)controller.tick(state, kControlPeriod);
  EXPECT_LT(controller.status().residual.norm(), 1e-3);
}

TEST(ArmController, StaysWithinTheLimitsForAFarSetPoint) {
  // The checks of every tick are the test: torque, its rate, joint positions and speeds.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "far"));
  for (const JointVector& pose : test_poses()) {
    for (int trial = 0; trial < 3; ++trial) {
      ControlledArm arm(model, pose);
      arm.tick();
      CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
      far.T_world_tcp.translation() += 1.0 * random.unit_vector();
      far.T_world_tcp.rotate(Eigen::AngleAxisd(M_PI, random.unit_vector()));
      arm.controller.set_cartesian_target(far);
      arm.run(3.0);
      EXPECT_NE(arm.controller.status().mode, ControlMode::kSafeStop);
    }
  }
}

TEST(ArmController, ASetPointThatJumpsIsApproached) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ControlledArm arm(model, pose);
  CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
  far.T_world_tcp.translation().x() -= 0.1;
  far.T_world_tcp.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  arm.controller.set_cartesian_target(far);
  arm.tick();
  arm.tick();
  EXPECT_LT(arm.controller.status().spring_wrench.head<3>().norm(), 2000.0 * 0.0024 + 1e-9);
  EXPECT_LT(arm.controller.status().spring_wrench.tail<3>().norm(), 200.0 * 0.006 + 1e-9);
  arm.run(2.0);
  const Eigen::Isometry3d error = far.T_world_tcp.inverse() * arm.controller.status().T_world_tcp;
  EXPECT_LT(error.translation().norm(), 1e-3);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 1e-2);
}

TEST(ArmController, ToleratesAMillisecondOfLatency) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ArmController controller(model);
  ArmPlant plant(model, pose);
  CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
  target.T_world_tcp.translation().y() += 0.02;
  controller.set_cartesian_target(target);
  JointVector late = model.gravity(pose);
  for (int i = 0; i < 4000; ++i) {
    const JointVector tau = controller.tick(plant.state(), kControlPeriod);
    plant.step(late);
    late = tau;
  }
  EXPECT_LT(plant.qd().norm(), 1e-3);
  EXPECT_LT(
      (model.forward_kinematics(plant.q()).translation() - target.T_world_tcp.translation()).norm(),
      1e-4);
}

TEST(ArmController, ABadSensorLeadsToASafeStopThatIsSaid) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[1];
  for (const double bad : {NAN, INFINITY}) {
    ControlledArm arm(model, pose);
    arm.plant.set_velocity(JointVector::Constant(0.3));
    arm.run(0.1);
    JointState broken = arm.plant.state();
    broken.q[3] = bad;
    const JointVector tau = arm.controller.tick(broken, kControlPeriod);
    EXPECT_TRUE(tau.allFinite());
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kSafeStop);
    EXPECT_EQ(arm.controller.status().fault, ControlFault::kBadState);

    // With the sensor back it brakes, but stays stopped until reset.
    arm.controller.set_joint_target({.q = pose + JointVector::Ones()});
    for (int i = 0; i < 1500; ++i) {
      arm.plant.step(arm.controller.tick(arm.plant.state(), kControlPeriod));
    }
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kSafeStop);
    EXPECT_LT(arm.plant.qd().norm(), 1e-3);

    arm.controller.reset();
    const JointVector resting = arm.plant.q();
    for (int i = 0; i < 200; ++i) {
      arm.plant.step(arm.controller.tick(arm.plant.state(), kControlPeriod));
    }
    EXPECT_EQ(arm.controller.status().fault, ControlFault::kNone);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kJoint);
    EXPECT_LT((arm.plant.q() - resting).norm(), 1e-3);
  }
}

TEST(ArmController, ABadTargetOrPeriodLeadsToASafeStopThatIsSaid) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  const JointState state{.q = pose, .tau = model.gravity(pose), .theta = pose};
  {
    ArmController controller(model);
    controller.set_joint_target({.q = JointVector::Constant(NAN)});
    EXPECT_TRUE(controller.tick(state, kControlPeriod).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kBadTarget);
  }
  {
    ArmController controller(model);
    CartesianTarget target;
    target.T_world_tcp.translation().x() = INFINITY;
    controller.set_cartesian_target(target);
    EXPECT_TRUE(controller.tick(state, kControlPeriod).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kBadTarget);
    // Nothing of it is left after a reset.
    controller.reset();
    controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(pose)});
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(controller.tick(state, kControlPeriod).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kNone);
    EXPECT_EQ(controller.status().mode, ControlMode::kCartesian);
  }
  for (const double dt : {0.0, -0.001, 1.0, double{NAN}}) {
    ArmController controller(model);
    EXPECT_TRUE(controller.tick(state, dt).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kBadPeriod);
  }
}

TEST(ArmController, RefusesOptionsWithoutMeaning) {
  ArmControllerOptions options;
  options.limiter.rate = -1.0;
  EXPECT_THROW(ArmController(testing::make_arm(), options), InputError);
}

}  // namespace
}  // namespace binpick
