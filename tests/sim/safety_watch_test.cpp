#include "sim/safety_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace binpick {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// An arm that does what it is told, until a test changes what the watch sees.
class SafetyWatchTest : public ::testing::Test {
 protected:
  /// The first finding within `periods`.
  std::optional<std::string> watch_for(int periods) {
    for (int i = 0; i < periods; ++i) {
      truth.q += kControlPeriod * truth.qd;
      if (!frozen) sensed = truth;
      sensed.tau = truth.tau;
      if (break_sensor) break_sensor(sensed);
      if (auto finding = watch.check(tau, truth, sensed)) return finding;
    }
    return std::nullopt;
  }

  SafetyWatch watch{load_lwr()};
  JointVector tau = JointVector::Zero();
  JointState truth;
  JointState sensed;
  bool frozen = false;
  std::function<void(JointState&)> break_sensor;
};

TEST_F(SafetyWatchTest, FindsNothingOnAnArmThatMovesWithinItsLimits) {
  truth.qd.setConstant(0.9);
  EXPECT_EQ(watch_for(1500), std::nullopt);
}

TEST_F(SafetyWatchTest, FindsTorquesBeyondTheEffort) {
  tau[6] = 38.5;
  EXPECT_THAT(watch_for(1).value_or(""), HasSubstr("joint 7: commanded torque 38.5 exceeds 38"));
}

TEST_F(SafetyWatchTest, FindsTorquesThatChangeTooFast) {
  ASSERT_EQ(watch_for(1), std::nullopt);
  tau[1] = 1.0;
  ASSERT_EQ(watch_for(1), std::nullopt);
  tau[1] = -0.01;
  EXPECT_THAT(watch_for(1).value_or(""), HasSubstr("joint 2: commanded torque rate"));
}

TEST_F(SafetyWatchTest, FindsPositionsAndSpeedsBeyondTheLimits) {
  truth.q[3] = 2.1;
  EXPECT_THAT(watch_for(1).value_or(""), HasSubstr("joint 4: position 2.1 is above"));
  truth.q[3] = -2.1;
  EXPECT_THAT(watch_for(1).value_or(""), HasSubstr("joint 4: position -2.1 is below"));
  truth.q[3] = 0.0;
  truth.qd[5] = -2.0;
  EXPECT_THAT(watch_for(1).value_or(""), HasSubstr("joint 6: speed -2 exceeds"));
}

TEST_F(SafetyWatchTest, FindsSensorsThatDeliverNoNumberWithPatience) {
  break_sensor = [](JointState& state) { state.tau[2] = kNan; };
  const int patience = static_cast<int>(SafetyWatch::kPatience / kControlPeriod);
  EXPECT_EQ(watch_for(patience - 1), std::nullopt);
  EXPECT_THAT(watch_for(2).value_or(""), HasSubstr("joint 3: the torque sensor"));
}

TEST_F(SafetyWatchTest, FindsFrozenSensorsOnAMovingArm) {
  truth.qd.setConstant(0.5);
  ASSERT_EQ(watch_for(30), std::nullopt);
  frozen = true;
  EXPECT_THAT(watch_for(2 * SafetyWatch::kWindow + 2).value_or(""),
              HasSubstr("position and velocity sensors differ"));
}

TEST_F(SafetyWatchTest, FindsTorquesThatDoNotFollowTheCommand) {
  break_sensor = [](JointState& state) { state.tau[0] = 60.0; };
  EXPECT_THAT(watch_for(2 * SafetyWatch::kWindow + 2).value_or(""),
              HasSubstr("joint 1: torque sensor and command differ by 60"));
}

}  // namespace
}  // namespace binpick
