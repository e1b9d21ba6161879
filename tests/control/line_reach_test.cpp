#include "control/line_reach.h"

#include <gtest/gtest.h>

#include "control/arm_plant.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

class LineReach : public ::testing::Test {
 protected:
  [[nodiscard]] std::optional<IkFailure> to(
      const Eigen::Vector3d& offset,
      const Eigen::AngleAxisd& turn = Eigen::AngleAxisd(0.0, Eigen::Vector3d::UnitX())) const {
    Eigen::Isometry3d goal = start_;
    goal.translation() += offset;
    goal.linear() = turn * goal.linear();
    return line_failure(kinematics_, start_, goal, q_);
  }

  const ArmModel arm_ = testing::make_arm();
  const InverseKinematics kinematics_{arm_};
  const JointVector q_ = test_poses()[0];
  const Eigen::Isometry3d start_ = arm_.forward_kinematics(q_);
};

TEST_F(LineReach, AnApproachInFrontOfTheArmIsPossible) {
  EXPECT_FALSE(to({0.0, 0.0, -0.1}));
  EXPECT_FALSE(to({0.05, 0.1, 0.05}, Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())));
  EXPECT_FALSE(to({0.0, 0.0, 0.0}));
}

TEST_F(LineReach, WhatLiesTooFarOrTooCloseIsSaid) {
  EXPECT_EQ(to({1.0, 0.0, 0.0}), IkFailure::kTooFar);
  const std::optional<IkFailure> close = to({-0.55, 0.0, 0.3});
  ASSERT_TRUE(close);
  EXPECT_NE(*close, IkFailure::kTooFar);
}

TEST_F(LineReach, ALineOnWhichAJointRunsIntoItsLimitIsRefused) {
  // Joint 7 stands at 69 degrees; turned on by 149 more it would have to come from the other side,
  // which is a posture for the goal, but no straight way there.
  const JointVector turned = q_ + 1.2 * JointVector::Unit(6);
  const Eigen::Isometry3d from = arm_.forward_kinematics(turned);
  Eigen::Isometry3d goal = from;
  goal.linear() = from.linear() * Eigen::AngleAxisd(2.6, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(kinematics_.solve(goal, turned));
  EXPECT_TRUE(line_failure(kinematics_, from, goal, turned));
}

}  // namespace
}  // namespace binpick
