#include "control/push_planner.h"

#include <gtest/gtest.h>

#include <cmath>

namespace binpick {
namespace {

/// Points on a box on the table, `x` from the base.
std::vector<Eigen::Vector3d> box_at(double x, double height = 0.07) {
  std::vector<Eigen::Vector3d> corners;
  for (const double dx : {-0.05, 0.05}) {
    for (double y = -0.09; y < 0.095; y += 0.01) {
      for (const double z : {0.0, height}) corners.emplace_back(x + dx, y, z);
    }
  }
  return corners;
}

bool always(const Push&) { return true; }

class PushPlannerTest : public ::testing::Test {
 protected:
  Eigen::Vector3d tip(const Eigen::Isometry3d& T_world_tcp) const {
    return T_world_tcp * Eigen::Vector3d(0.0, 0.0, gripper_.tip_beyond_tcp);
  }

  CellLayout layout_;
  GripperDescription gripper_ = load_gripper();
};

TEST_F(PushPlannerTest, PushesOutwardWhatIsTooNearFromItsInnerSide) {
  const auto push = plan_push(box_at(0.38), layout_, gripper_, always);
  ASSERT_TRUE(push);
  EXPECT_LT(tip(push->T_world_start).x(), 0.38 - 0.05);
  EXPECT_NEAR(tip(push->T_world_start).z(), PushOptions{}.tip_height, 1e-9);
  const Eigen::Vector3d way = push->T_world_end.translation() - push->T_world_start.translation();
  EXPECT_GT(way.x(), 0.1);
  EXPECT_NEAR(way.y(), 0.0, 1e-9);
  EXPECT_NEAR(way.z(), 0.0, 1e-9);
}

TEST_F(PushPlannerTest, PushesInwardWhatIsTooFarFromItsOuterSide) {
  const auto push = plan_push(box_at(0.80), layout_, gripper_, always);
  ASSERT_TRUE(push);
  EXPECT_GT(tip(push->T_world_start).x(), 0.80 + 0.05);
  EXPECT_LT(push->T_world_end.translation().x(), push->T_world_start.translation().x());
}

TEST_F(PushPlannerTest, LeavesAloneWhatLiesWell) {
  EXPECT_FALSE(plan_push(box_at(0.55), layout_, gripper_, always));
}

TEST_F(PushPlannerTest, LeansNoMoreThanItMustAndThenSetsOutFarther) {
  const auto leaning = [](const Push& push) {
    return push.T_world_start.linear()(2, 2) > -std::cos(0.3);
  };
  const auto upright = plan_push(box_at(0.38), layout_, gripper_, always);
  const auto leant = plan_push(box_at(0.38), layout_, gripper_, leaning);
  ASSERT_TRUE(upright && leant);
  EXPECT_NEAR(upright->T_world_start.linear()(2, 2), -1.0, 1e-12);
  EXPECT_NEAR(std::acos(-leant->T_world_start.linear()(2, 2)) * 180.0 / M_PI, 20.0, 1e-6);
  EXPECT_LT(tip(leant->T_world_start).x(), tip(upright->T_world_start).x());
  // Coming down along the leaning fingers, no corner is met.
  const Eigen::Isometry3d T_tcp_world = leant->T_world_start.inverse();
  for (const Eigen::Vector3d& corner : box_at(0.38)) {
    const Eigen::Vector3d p_tcp = T_tcp_world * corner;
    EXPECT_GT(std::abs(p_tcp.x()), 0.5 * gripper_.pad_width) << corner.transpose();
  }
}

TEST_F(PushPlannerTest, WhatReachesFarBackBesideTheFingersDoesNotKeepThemAway) {
  std::vector<Eigen::Vector3d> oblique = box_at(0.38);
  for (const double x : {-0.09, 0.09}) oblique.emplace_back(0.38 + x, x, 0.0);
  const auto plain = plan_push(box_at(0.38), layout_, gripper_, always);
  const auto push = plan_push(oblique, layout_, gripper_, always);
  ASSERT_TRUE(plain && push);
  EXPECT_NEAR(tip(push->T_world_start).x(), tip(plain->T_world_start).x(), 1e-9);
}

TEST_F(PushPlannerTest, RaisesTheTipsWhereTheLowFingersWouldHaveToSetOutTooNearTheBase) {
  double nearest = 1.0;
  const auto from_farther_out = [&](const Push& push) {
    const double x = tip(push.T_world_start).x();
    const bool raised = tip(push.T_world_start).z() > PushOptions{}.tip_height + 1e-9;
    const bool leant = push.T_world_start.linear()(2, 2) > -std::cos(0.8);
    if (!raised && leant) nearest = x;
    return raised && leant;
  };
  const auto push = plan_push(box_at(0.38), layout_, gripper_, from_farther_out);
  ASSERT_TRUE(push);
  EXPECT_NEAR(tip(push->T_world_start).z(), 0.035, 1e-9);
  EXPECT_GT(tip(push->T_world_start).x(), nearest + 0.02);
}

TEST_F(PushPlannerTest, GivesUpWhereNoLeanIsFeasible) {
  EXPECT_FALSE(plan_push(box_at(0.38), layout_, gripper_, [](const Push&) { return false; }));
}

}  // namespace
}  // namespace binpick
