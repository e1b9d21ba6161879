#include "control/joint_limit_barrier.h"

#include <gtest/gtest.h>

#include <cmath>

#include "control/arm_plant.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

constexpr double kTorqueRate = 1000.0;  // Nm/s

/// The plant driven by torques that the limiter and then the barrier let through.
struct GuardedArm {
  explicit GuardedArm(const JointVector& pose)
      : model(testing::make_arm()),
        plant(model, pose),
        limiter(model.limits(), {kTorqueRate}),
        barrier(model.limits(), kTorqueRate) {}

  void tick(const JointVector& control) {
    const ArmDynamics dynamics = plant.dynamics();
    const OperationalSpace space(dynamics.M, dynamics.J);
    limited = *limiter.limit(dynamics.gravity, control, kControlPeriod);
    const JointVector untouched = JointVector::Zero();
    kept = barrier.keep(limited, limiter.range(),
                        {dynamics, space, plant.q(), plant.qd(), untouched, false}, kControlPeriod);
    limiter.start(kept);
    plant.step(kept);
  }

  ArmModel model;
  ArmPlant plant;
  TorqueLimiter limiter;
  JointLimitBarrier barrier;
  JointVector limited = JointVector::Zero();
  JointVector kept = JointVector::Zero();
};

TEST(JointLimitBarrier, LetsSlowJointsHaveTheirTorques) {
  GuardedArm arm(test_poses()[1]);
  for (int i = 0; i < 100; ++i) {
    arm.tick(0.3 * arm.plant.dynamics().M.diagonal());
    EXPECT_EQ(arm.kept, arm.limited);
  }
}

TEST(JointLimitBarrier, KeepsSpeedsAndPositionsWhateverIsAskedFor) {
  // Torques of up to a tenth of the effort, drawn anew every 0.2 s, with no law and no damping
  // behind them. (The barrier is no proof: with a fifth of the effort a joint was 9 % too fast,
  // since the other joints' torques may change as quickly as the one that brakes.)
  Random random(derive_seed(3, "torques"));
  double fastest = 0.0;
  for (const JointVector& pose : test_poses()) {
    GuardedArm arm(pose);
    const JointLimits& limits = arm.model.limits();
    JointVector control;
    for (int i = 0; i < 2000; ++i) {
      if (i % 200 == 0) {
        control = 0.1 * limits.effort.cwiseProduct(testing::random_vector(random, 1.0));
      }
      arm.tick(control);
      const TorqueRange& range = arm.limiter.range();
      ASSERT_TRUE(((arm.kept - range.lowest).array() >= 0.0).all());
      ASSERT_TRUE(((range.highest - arm.kept).array() >= 0.0).all());
      ASSERT_TRUE(limits.contains(arm.plant.q())) << arm.plant.q().transpose();
      fastest =
          std::max(fastest, arm.plant.qd().cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff());
    }
  }
  EXPECT_LE(fastest, 1.0);
  EXPECT_GT(fastest, 0.85) << "nothing came near a limit";
}

TEST(JointLimitBarrier, BrakesAFastJointThatMayStillBePushed) {
  const JointVector pose = test_poses()[0];
  GuardedArm arm(pose);
  ArmDynamics dynamics = arm.model.evaluate(pose, JointVector::Zero());
  const OperationalSpace space(dynamics.M, dynamics.J);
  const JointVector rate = 0.9 * arm.model.limits().velocity[3] * JointVector::Unit(3);
  const JointVector push = 20.0 * JointVector::Unit(3);
  const JointVector nothing = JointVector::Zero();
  const TorqueRange range{dynamics.gravity - JointVector::Constant(100.0),
                          dynamics.gravity + JointVector::Constant(100.0)};
  const auto torque = [&](const JointVector& residual) {
    return arm.barrier.keep(dynamics.gravity, range,
                            {dynamics, space, pose, rate, residual, !residual.isZero(0.0)},
                            kControlPeriod)[3];
  };
  EXPECT_DOUBLE_EQ(torque(nothing), dynamics.gravity[3]);
  EXPECT_LT(torque(push), dynamics.gravity[3] - 5.0);
}

}  // namespace
}  // namespace binpick
