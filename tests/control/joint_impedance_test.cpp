#include "control/joint_impedance.h"

#include <gtest/gtest.h>

#include "control/arm_plant.h"
#include "control/joint_trajectory.h"
#include "control/test_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

void step(JointImpedance& law, ArmPlant& plant, const JointTarget& target,
          const JointVector& external) {
  const ArmDynamics dynamics = plant.dynamics();
  const JointVector tau = law.torques(dynamics, plant.q(), plant.qd(), target) + dynamics.gravity;
  plant.step(tau, [&](const ArmDynamics&, const JointVector&) { return external; });
}

TEST(JointImpedance, StaticStiffnessIsAsAsked) {
  const ArmModel model = testing::make_arm();
  const JointImpedanceOptions options;
  for (const JointVector& pose : test_poses()) {
    for (int joint = 0; joint < kArmJoints; ++joint) {
      JointImpedance law(model.limits(), options);
      ArmPlant plant(model, pose);
      JointVector external = JointVector::Zero();
      external[joint] = 5.0;
      for (int i = 0; i < 1500; ++i) step(law, plant, {.q = pose}, external);
      const JointVector expected = external.cwiseQuotient(options.stiffness);
      EXPECT_LT((plant.q() - pose - expected).norm(), 0.02 * expected.norm());
    }
  }
}

TEST(JointImpedance, TracksAFastMotionWithoutLag) {
  const ArmModel model = testing::make_arm();
  const std::vector<JointVector> poses = test_poses();
  const JointTrajectory trajectory({poses[0], poses[1], poses[2]}, model.limits(), {.speed = 1.0});
  JointImpedance law(model.limits(), {});
  ArmPlant plant(model, poses[0]);
  double worst = 0.0;
  for (int i = 0; i * kControlPeriod < trajectory.duration(); ++i) {
    const JointTarget now = trajectory.sample(i * kControlPeriod);
    step(law, plant, {now.q, now.qd, now.qdd}, JointVector::Zero());
    const JointTarget next = trajectory.sample((i + 1) * kControlPeriod);
    worst = std::max(worst, (plant.q() - next.q).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 0.002);
}

TEST(JointImpedance, SpringIsBoundedHoweverFarTheTarget) {
  const ArmModel model = testing::make_arm();
  JointImpedance law(model.limits(), {.max_spring_share = 0.2});
  const JointVector pose = test_poses()[0];
  const ArmDynamics dynamics = model.evaluate(pose, JointVector::Zero());
  const JointVector tau =
      law.torques(dynamics, pose, JointVector::Zero(), {.q = pose + JointVector::Constant(3.0)});
  EXPECT_LT((tau - 0.2 * model.limits().effort).norm(), 1e-9);
}

TEST(JointImpedance, StoresNoMoreEnergyThanIsPutIn) {
  const ArmModel model = testing::make_arm();
  const JointImpedanceOptions options;
  JointImpedance law(model.limits(), options);
  const JointVector pose = test_poses()[1];
  ArmPlant plant(model, pose);
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    JointVector push = JointVector::Zero();
    push[(i / 200) % kArmJoints] = (i / 200) % 2 == 0 ? 12.0 : -8.0;
    step(law, plant, {.q = pose}, push);
    const JointVector error = plant.q() - pose;
    const double stored =
        plant.kinetic_energy() + 0.5 * error.dot(options.stiffness.asDiagonal() * error);
    worst = std::max(worst, stored - plant.external_work());
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(plant.external_work(), 0.1);
}

TEST(JointImpedance, RefusesOptionsWithoutMeaning) {
  JointImpedanceOptions options;
  options.stiffness[3] = 0.0;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace binpick
