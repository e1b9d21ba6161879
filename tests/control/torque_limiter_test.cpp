#include "control/torque_limiter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "control/arm_plant.h"
#include "control/test_arm.h"
#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

TEST(TorqueLimiter, LeavesTorquesWithinTheLimitsAlone) {
  const JointLimits limits = testing::make_arm().limits();
  TorqueLimiter limiter(limits, {.rate = 1e9});
  const JointVector gravity = 0.2 * limits.effort;
  const JointVector control = -0.5 * limits.effort;
  EXPECT_LT((*limiter.limit(gravity, control, 0.001) - (gravity + control)).norm(), 1e-12);
  EXPECT_EQ(limiter.share(), 1.0);
}

TEST(TorqueLimiter, ScalesControlUniformlyAndGravityNever) {
  const JointLimits limits = testing::make_arm().limits();
  Random random(derive_seed(5, "torques"));
  for (int trial = 0; trial < 1000; ++trial) {
    TorqueLimiter limiter(limits, {.rate = 1e9});
    JointVector gravity;
    JointVector control;
    for (int i = 0; i < kArmJoints; ++i) {
      gravity[i] = limits.effort[i] * random.uniform(-0.9, 0.9);
      control[i] = limits.effort[i] * random.uniform(-4.0, 4.0);
    }
    const JointVector tau = *limiter.limit(gravity, control, 0.001);
    EXPECT_LE((tau.cwiseAbs() - limits.effort).maxCoeff(), 1e-9);
    EXPECT_LT((tau - gravity - limiter.share() * control).norm(), 1e-9);
    // Not scaled down more than needed.
    const double fullest = tau.cwiseAbs().cwiseQuotient(limits.effort).maxCoeff();
    EXPECT_TRUE(limiter.share() == 1.0 || fullest > 1.0 - 1e-9);
  }
}

TEST(TorqueLimiter, LimitsTheRateOfEveryJoint) {
  const JointLimits limits = testing::make_arm().limits();
  TorqueLimiter limiter(limits, {});
  const JointVector gravity = JointVector::Constant(3.0);
  JointVector last = gravity;
  for (int i = 0; i < 100; ++i) {
    const JointVector control = 0.8 * limits.effort * (i < 50 ? 1.0 : -1.0);
    const JointVector tau = *limiter.limit(gravity, control, 0.001);
    EXPECT_LE((tau - last).cwiseAbs().maxCoeff(), 1.0 + 1e-9);
    last = tau;
  }
}

TEST(TorqueLimiter, RefusesWhatIsNotFinite) {
  TorqueLimiter limiter(testing::make_arm().limits(), {});
  const JointVector good = JointVector::Zero();
  for (const double bad : {NAN, INFINITY, -INFINITY}) {
    JointVector broken = good;
    broken[4] = bad;
    EXPECT_FALSE(limiter.limit(good, broken, 0.001));
    EXPECT_FALSE(limiter.limit(broken, good, 0.001));
    EXPECT_FALSE(limiter.limit(good, good, bad));
  }
  EXPECT_TRUE(limiter.limit(good, good, 0.001));
}

TEST(TorqueLimiter, RefusesARateWithoutMeaning) {
  EXPECT_THROW(TorqueLimiter(testing::make_arm().limits(), {.rate = 0.0}), InputError);
}

}  // namespace
}  // namespace binpick
