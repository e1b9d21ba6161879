#include "control/contact_monitor.h"

#include <gtest/gtest.h>

#include "control/arm_plant.h"
#include "control/test_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

ContactClass after(ContactMonitor& monitor, double force, int ticks,
                   const JointVector& residual = JointVector::Zero()) {
  for (int i = 0; i < ticks; ++i) monitor.update(force * Vector6::Unit(2), residual);
  return monitor.contact_class();
}

TEST(ContactMonitor, ForceMagnitudeTellsContactFromCollision) {
  ContactMonitor monitor({});
  EXPECT_EQ(after(monitor, 4.9, 10), ContactClass::kNone);
  EXPECT_EQ(after(monitor, 5.1, 1), ContactClass::kContact);
  EXPECT_EQ(after(monitor, 14.9, 10), ContactClass::kContact);
  EXPECT_FALSE(monitor.hf1());
  EXPECT_EQ(after(monitor, 15.0, 2), ContactClass::kCollision);
  EXPECT_TRUE(monitor.hf1());
}

TEST(ContactMonitor, DirectionOfTheForceDoesNotMatter) {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0.6, 0, -0.8)}) {
    ContactMonitor monitor({});
    Vector6 wrench = Vector6::Zero();
    wrench.head<3>() = 16.0 * direction;
    monitor.update(wrench, JointVector::Zero());
    monitor.update(wrench, JointVector::Zero());
    EXPECT_TRUE(monitor.hf1());
  }
}

TEST(ContactMonitor, ASingleSpikeIsNoCollision) {
  ContactMonitor monitor({.samples = 3});
  for (int i = 0; i < 20; ++i) {
    EXPECT_NE(after(monitor, 40.0, 2), ContactClass::kCollision);
    EXPECT_NE(after(monitor, 0.0, 1), ContactClass::kCollision);
  }
  EXPECT_EQ(after(monitor, 40.0, 3), ContactClass::kCollision);
}

TEST(ContactMonitor, StatesEndAtHalfTheThreshold) {
  ContactMonitor monitor({});
  EXPECT_EQ(after(monitor, 20.0, 2), ContactClass::kCollision);
  EXPECT_EQ(after(monitor, 7.6, 50), ContactClass::kCollision);
  EXPECT_EQ(after(monitor, 7.4, 1), ContactClass::kContact);
  EXPECT_EQ(after(monitor, 2.6, 50), ContactClass::kContact);
  EXPECT_EQ(after(monitor, 2.4, 1), ContactClass::kNone);
}

TEST(ContactMonitor, AnElbowCollisionShowsInTheJoints) {
  ContactMonitor monitor({});
  const JointVector residual = -2.5 * JointVector::Unit(1);
  EXPECT_EQ(after(monitor, 0.0, 2, residual), ContactClass::kCollision);
  EXPECT_EQ(after(monitor, 0.0, 5, 0.6 * residual), ContactClass::kCollision);
  EXPECT_EQ(after(monitor, 0.0, 1, 0.3 * residual), ContactClass::kNone);
}

TEST(ContactMonitor, PhasesDifferInTheirJointThresholds) {
  const JointLimits limits = testing::make_arm().limits();
  const ContactThresholds free = ContactThresholds::for_phase(ContactPhase::kFree, limits);
  EXPECT_NEAR(free.joint_torque[0], 0.05 * limits.effort[0], 1e-12);
  EXPECT_NEAR(free.joint_torque[6], 2.0, 1e-12);
  // Where the tool may touch, 15 N at the tool centre, whatever their direction, stay below the
  // joint thresholds: the paper's criterion decides.
  const ArmModel model = testing::make_arm();
  for (const ContactPhase phase :
       {ContactPhase::kApproach, ContactPhase::kGrasp, ContactPhase::kPlace}) {
    const ContactThresholds thresholds = ContactThresholds::for_phase(phase, limits);
    for (const JointVector& pose : test_poses()) {
      const Jacobian J = model.jacobian(pose);
      for (int joint = 0; joint < kArmJoints; ++joint) {
        EXPECT_LT(thresholds.collision_force * J.col(joint).head<3>().norm(),
                  thresholds.joint_torque[joint]);
      }
    }
  }
}

TEST(ContactMonitor, RefusesThresholdsWithoutMeaning) {
  EXPECT_THROW(ContactThresholds({.contact_force = 20.0}).validate(), InputError);
  EXPECT_THROW(ContactThresholds({.samples = 0}).validate(), InputError);
  EXPECT_NO_THROW(ContactThresholds({}).validate());
}

}  // namespace
}  // namespace binpick
