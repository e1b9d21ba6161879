#include "control/transfer_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/joint_trajectory.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

using testing::degrees;
using testing::make_arm;

constexpr double kPi = std::numbers::pi;

/// A cell like the clean-up scene's: pick region in front, bins to the left, a corner to the right.
CellLayout make_layout() {
  CellLayout layout;
  layout.pick_region =
      Eigen::AlignedBox2d(Eigen::Vector2d(0.30, -0.25), Eigen::Vector2d(0.80, 0.25));
  layout.places = {
      {"bottle bin",
       {"bottle"},
       {0.0, 0.575},
       {{-0.1, 0.575}, {0.1, 0.575}},
       {0.34, 0.25},
       0.0,
       0.08},
      {"amicelli bin", {"amicelli"}, {-0.385, 0.43}, {{-0.45, 0.43}}, {0.30, 0.25}, 0.0, 0.08},
      {"rusk corner",
       {"rusk"},
       {0.13, -0.55},
       {{0.01, -0.55}, {0.25, -0.55}},
       {0.48, 0.22},
       0.0,
       0.0}};
  layout.overview = degrees(90, -14, 0, 97, 0, -69, 0);
  layout.transfer_height = 0.34;
  return layout;
}

Eigen::Isometry3d top_down(const Eigen::Vector3d& p, double yaw, double tilt = 0.0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = p;
  T.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  T.rotate(Eigen::AngleAxisd(kPi - tilt, Eigen::Vector3d::UnitY()));
  return T;
}

class TransferPlannerTest : public ::testing::Test {
 protected:
  /// Somewhere in the pick region within the reach ring, jaws turned and tilted at random.
  Eigen::Isometry3d random_grasp() {
    for (;;) {
      const Eigen::Vector3d p(random_.uniform(0.30, 0.75), random_.uniform(-0.25, 0.25),
                              random_.uniform(0.08, 0.22));
      const double radius = p.head<2>().norm();
      if (radius < 0.42 || radius > 0.70) continue;
      return top_down(p, random_.uniform(-0.5 * kPi, 0.5 * kPi), random_.uniform(-0.3, 0.3));
    }
  }

  /// Whether the blended motion along `path` is safe, looked at every millisecond.
  void expect_safe(const TransferPlanner::Path& path) {
    const JointTrajectory motion(path, arm_.limits());
    const Eigen::Vector3d p_start = arm_.forward_kinematics(path.front()).translation();
    const Eigen::Vector3d p_goal = arm_.forward_kinematics(path.back()).translation();
    const double foot = std::min({p_start.z(), p_goal.z(), layout_.transfer_height - 0.03});
    for (double t = 0.0; t < motion.duration(); t += 0.005) {
      const JointVector q = motion.sample(t).q;
      EXPECT_TRUE(arm_.limits().contains(q));
      EXPECT_GT(clearance_.to_itself(q), 0.01);
      EXPECT_GT(clearance_.to_cell(q), 0.0);
      const Eigen::Vector3d p = arm_.forward_kinematics(q).translation();
      EXPECT_GT(p.z(), foot - 0.01);
      const double to_columns =
          std::min((p - p_start).head<2>().norm(), (p - p_goal).head<2>().norm());
      // Low only near a column; blending cuts the corner at its head.
      if (p.z() < layout_.transfer_height - 0.05) {
        EXPECT_LT(to_columns, 0.06) << "t = " << t << ", tool at " << p.transpose();
      }
    }
  }

  const ArmModel arm_ = make_arm();
  const InverseKinematics kinematics_{arm_};
  const CellLayout layout_ = make_layout();
  const TransferPlanner planner_{arm_, kinematics_, layout_};
  const ArmClearance clearance_{arm_, layout_};
  Random random_{77};
};

TEST_F(TransferPlannerTest, OverviewToEveryGraspAndBack) {
  int reachable = 0;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Isometry3d T_world_grasp = random_grasp();
    const auto there = planner_.plan(layout_.overview, T_world_grasp);
    if (!there) continue;
    ++reachable;
    EXPECT_LT((arm_.forward_kinematics(there->back()).matrix() - T_world_grasp.matrix()).norm(),
              1e-9);
    expect_safe(*there);
    const auto back = planner_.plan(there->back(), layout_.overview);
    ASSERT_TRUE(back) << there->back().transpose();
    expect_safe(*back);
  }
  EXPECT_GE(reachable, 95);
}

TEST_F(TransferPlannerTest, CarriesFromEveryGraspToEveryPlace) {
  int planned = 0;
  int asked = 0;
  for (int i = 0; i < 15; ++i) {
    const auto start = planner_.plan(layout_.overview, random_grasp());
    if (!start) continue;
    for (const Place& place : layout_.places) {
      for (const Eigen::Vector2d& slot : place.slots) {
        const double yaw = std::atan2(slot.y(), slot.x());
        ++asked;
        const auto path = planner_.plan(
            start->back(), top_down({slot.x(), slot.y(), 0.26}, yaw + random_.uniform(-0.5, 0.5)));
        if (!path) continue;
        ++planned;
        expect_safe(*path);
      }
    }
  }
  EXPECT_GE(asked, 60);
  EXPECT_GE(planned, asked * 95 / 100) << asked;
}

TEST_F(TransferPlannerTest, GoesRoundWhereTheDirectLineIsUnsafe) {
  // High postures in any branch: straight lines between them often sweep through table or column.
  const auto high_posture = [&] {
    for (;;) {
      const JointVector q = testing::random_posture(random_, arm_.limits(), 0.9);
      const double height = arm_.forward_kinematics(q).translation().z();
      if (height > 0.40 && height < 0.60 && planner_.clear(q)) return q;
    }
  };
  int planned = 0;
  int round = 0;
  for (int i = 0; i < 200; ++i) {
    const auto path = planner_.plan(high_posture(), high_posture());
    if (!path) continue;
    ++planned;
    round += path->size() > 2 ? 1 : 0;
    expect_safe(*path);
  }
  EXPECT_GE(planned, 20);
  EXPECT_GE(round, 1) << planned;
}

TEST_F(TransferPlannerTest, WaypointsBeginAndEndWhereAskedAndTheToolIsLifted) {
  const auto from = planner_.top_down_posture({0.5, -0.2, 0.12});
  const auto to = planner_.top_down_posture({0.5, 0.2, 0.12});
  ASSERT_TRUE(from && to);
  const auto path = planner_.plan(*from, *to);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->front(), *from);
  EXPECT_EQ(path->back(), *to);
  double highest = 0.0;
  for (const JointVector& q : *path) {
    highest = std::max(highest, arm_.forward_kinematics(q).translation().z());
  }
  EXPECT_GE(highest, layout_.transfer_height);
}

TEST_F(TransferPlannerTest, PosturesStayContinuous) {
  for (int i = 0; i < 30; ++i) {
    const auto path = planner_.plan(layout_.overview, random_grasp());
    if (!path) continue;
    for (std::size_t k = 0; k + 1 < path->size(); ++k) {
      const JointVector step = (*path)[k + 1] - (*path)[k];
      // Joints 1 and 7 turn the arm and the tool; the others never need half a turn.
      EXPECT_LT(step.segment<5>(1).cwiseAbs().maxCoeff(), 0.6 * kPi);
    }
  }
}

TEST_F(TransferPlannerTest, TopDownPosturesCoverTheRingWithRaisedElbow) {
  for (const double radius : {0.40, 0.45, 0.55, 0.65, 0.74}) {
    for (double azimuth = -2.6; azimuth <= 2.6; azimuth += 0.2) {
      const Eigen::Vector3d p(radius * std::cos(azimuth), radius * std::sin(azimuth), 0.10);
      const auto q = planner_.top_down_posture(p);
      ASSERT_TRUE(q) << radius << " m, " << azimuth << " rad";
      const Eigen::Isometry3d T = arm_.forward_kinematics(*q);
      EXPECT_LT((T.translation() - p).norm(), 1e-9);
      EXPECT_NEAR(T.linear()(2, 2), -1.0, 1e-9);
      EXPECT_GT(arm_.elbow(*q).p_world.z(), 0.42);
    }
  }
}

TEST_F(TransferPlannerTest, NoPathIntoTheTableTheColumnOrOutOfReach) {
  EXPECT_FALSE(planner_.plan(layout_.overview, top_down({0.55, 0.0, -0.05}, 0.0)));
  EXPECT_FALSE(planner_.plan(layout_.overview, top_down({0.05, 0.0, 0.10}, 0.0)));
  EXPECT_FALSE(planner_.plan(layout_.overview, top_down({1.1, 0.0, 0.10}, 0.0)));
  const JointVector folded = degrees(0, 118, 0, 0, 0, 0, 0);  // the forearm under the table
  EXPECT_FALSE(planner_.clear(folded));
  EXPECT_FALSE(planner_.plan(layout_.overview, folded));
}

TEST_F(TransferPlannerTest, OverALowPileTheArmStoopsToWhatLiesNearTheBase) {
  const Eigen::Isometry3d T_world_near = top_down({0.30, 0.0, 0.10}, 0.0, -50.0 * kPi / 180.0);
  EXPECT_FALSE(planner_.plan(layout_.overview, T_world_near));
  const TransferPlanner low = planner_.over_pile(0.09);
  const auto path = low.plan(layout_.overview, T_world_near);
  ASSERT_TRUE(path);
  ArmClearanceOptions options;
  options.pile_height = 0.09;
  const ArmClearance over_low_pile(arm_, layout_, options);
  const JointTrajectory motion(*path, arm_.limits());
  for (double t = 0.0; t < motion.duration(); t += 0.005) {
    EXPECT_GT(over_low_pile.to_cell(motion.sample(t).q), 0.0);
    EXPECT_GT(clearance_.to_itself(motion.sample(t).q), 0.01);
  }
}

TEST_F(TransferPlannerTest, TheSameQuestionHasTheSameAnswer) {
  const Eigen::Isometry3d T_world_grasp = random_grasp();
  const TransferPlanner other(arm_, kinematics_, layout_);
  EXPECT_EQ(*planner_.plan(layout_.overview, T_world_grasp),
            *other.plan(layout_.overview, T_world_grasp));
}

TEST(ArmClearance, CapsuleDistancesAreThoseOfTheirAxesLessTheRadii) {
  Random random(9);
  const auto point = [&] {
    return Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  };
  for (int i = 0; i < 200; ++i) {
    const Capsule a{point(), point(), 0.1};
    const Capsule b{point(), point(), 0.05};
    double sampled = 1e9;
    constexpr int kSteps = 200;
    for (int m = 0; m <= kSteps; ++m) {
      for (int n = 0; n <= kSteps; ++n) {
        const Eigen::Vector3d p = a.a + (a.b - a.a) * (double(m) / kSteps);
        const Eigen::Vector3d r = b.a + (b.b - b.a) * (double(n) / kSteps);
        sampled = std::min(sampled, (p - r).norm());
      }
    }
    EXPECT_LE(distance(a, b), sampled - 0.15 + 1e-12);
    EXPECT_NEAR(distance(a, b), sampled - 0.15, 0.01);
  }
}

TEST(ArmClearance, LinksOverABinNeedMoreHeight) {
  const ArmModel arm = make_arm();
  CellLayout empty;
  const JointVector low = degrees(0, -60, 0, 60, 0, -60, 0);
  CellLayout with_bin = empty;
  with_bin.places = {{"bin", {}, {0.4, 0.0}, {{0.4, 0.0}}, {0.5, 0.5}, 0.0, 0.30}};
  const double over_table = ArmClearance(arm, empty).to_cell(low);
  const double over_bin = ArmClearance(arm, with_bin).to_cell(low);
  EXPECT_LT(over_bin, over_table);
  with_bin.places[0].p_world.x() = -2.0;
  EXPECT_EQ(ArmClearance(arm, with_bin).to_cell(low), over_table);
}

}  // namespace
}  // namespace binpick
