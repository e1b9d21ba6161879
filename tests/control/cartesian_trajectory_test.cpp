#include "control/cartesian_trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "control/test_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

using testing::rotation_between;

Eigen::Isometry3d random_pose(Random& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(0.0, 0.5);
  T.linear() = random.rotation().toRotationMatrix();
  return T;
}

TEST(CartesianTrajectory, TheToolMovesOnAStraightLineAndTurnsAboutOneAxis) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d from = random_pose(random);
    const Eigen::Isometry3d to = random_pose(random);
    const CartesianTrajectory trajectory(from, to);
    const Eigen::Vector3d travel = to.translation() - from.translation();
    const Eigen::Vector3d turn = rotation_between(from.linear(), to.linear());
    for (double t = 0.0; t <= trajectory.duration(); t += 0.02) {
      const Eigen::Isometry3d T = trajectory.sample(t).T_world_tcp;
      const Eigen::Vector3d done = T.translation() - from.translation();
      const Eigen::Vector3d turned = rotation_between(from.linear(), T.linear());
      const double share = done.dot(travel) / travel.squaredNorm();
      EXPECT_LT((done - share * travel).norm(), 1e-12);
      EXPECT_LT((turned - share * turn).norm(), 1e-7);
    }
    EXPECT_EQ(trajectory.sample(trajectory.duration()).T_world_tcp.matrix(), to.matrix());
    EXPECT_LT(
        (trajectory.sample(trajectory.duration() - 1e-9).T_world_tcp.matrix() - to.matrix()).norm(),
        1e-8);
    EXPECT_LT((trajectory.sample(0.0).T_world_tcp.matrix() - from.matrix()).norm(), 1e-12);
  }
}

TEST(CartesianTrajectory, TwistAndAccelerationAreTheDerivatives) {
  Random random(4);
  const CartesianTrajectory trajectory(random_pose(random), random_pose(random));
  constexpr double kStep = 1e-5;
  for (double t = 0.01; t < trajectory.duration() - 0.01; t += 0.017) {
    const CartesianTarget before = trajectory.sample(t - kStep);
    const CartesianTarget here = trajectory.sample(t);
    const CartesianTarget after = trajectory.sample(t + kStep);
    Vector6 twist;
    twist << after.T_world_tcp.translation() - before.T_world_tcp.translation(),
        rotation_between(before.T_world_tcp.linear(), after.T_world_tcp.linear());
    EXPECT_LT((twist / (2.0 * kStep) - here.twist).norm(), 1e-6);
    EXPECT_LT(((after.twist - before.twist) / (2.0 * kStep) - here.acceleration).norm(), 1e-2);
  }
}

TEST(CartesianTrajectory, RespectsLinearAndAngularLimits) {
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    CartesianMotionLimits limits;
    limits.linear.velocity = random.uniform(0.05, 1.0);
    limits.angular.velocity = random.uniform(0.2, 3.0);
    const CartesianTrajectory trajectory(random_pose(random), random_pose(random), limits);
    for (double t = 0.0; t <= trajectory.duration(); t += 0.002) {
      const CartesianTarget sample = trajectory.sample(t);
      EXPECT_LE(sample.twist.head<3>().norm(), limits.linear.velocity + 1e-9);
      EXPECT_LE(sample.twist.tail<3>().norm(), limits.angular.velocity + 1e-9);
      EXPECT_LE(sample.acceleration.head<3>().norm(), limits.linear.acceleration + 1e-9);
      EXPECT_LE(sample.acceleration.tail<3>().norm(), limits.angular.acceleration + 1e-9);
    }
  }
}

// The set-up of the collision experiments: 0.8 m/s within the approach.
TEST(CartesianTrajectory, ReachesTheWantedSpeedWhereThereIsRoom) {
  const auto fastest = [](double length, const CartesianMotionLimits& limits) {
    Eigen::Isometry3d to = Eigen::Isometry3d::Identity();
    to.translation().z() = -length;
    const CartesianTrajectory trajectory(Eigen::Isometry3d::Identity(), to, limits);
    double speed = 0.0;
    for (double t = 0.0; t < trajectory.duration(); t += 1e-4) {
      speed = std::max(speed, trajectory.sample(t).twist.norm());
    }
    return speed;
  };
  EXPECT_NEAR(fastest(0.1, CartesianMotionLimits::at_speed(0.1)), 0.1, 1e-9);
  EXPECT_NEAR(fastest(0.026, CartesianMotionLimits{}), 0.25, 1e-3);
  EXPECT_LT(fastest(0.1, CartesianMotionLimits::at_speed(0.8)), 0.7);
  CartesianMotionLimits quick = CartesianMotionLimits::at_speed(0.8);
  quick.linear.acceleration = 8.0;
  quick.linear.jerk = 400.0;
  EXPECT_NEAR(fastest(0.1, quick), 0.8, 1e-9);
}

TEST(CartesianTrajectory, StandingStillAndTurningOnTheSpotWork) {
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_EQ(CartesianTrajectory(here, here).duration(), 0.0);
  EXPECT_EQ(CartesianTrajectory(here, here).sample(1.0).twist, Vector6::Zero());
  Eigen::Isometry3d turned = here;
  turned.rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX()));
  const CartesianTrajectory turn(here, turned);
  EXPECT_GT(turn.duration(), 1.0);
  EXPECT_EQ(turn.sample(0.5).T_world_tcp.translation(), Eigen::Vector3d::Zero());
}

TEST(CartesianTrajectory, CanBeStretched) {
  Random random(6);
  const CartesianTrajectory plain(random_pose(random), random_pose(random));
  const CartesianTrajectory slower = plain.stretched_to(10.0);
  EXPECT_NEAR(slower.duration(), 10.0, 1e-12);
  EXPECT_LT((slower.sample(5.0).T_world_tcp.matrix() -
             plain.sample(0.5 * plain.duration()).T_world_tcp.matrix())
                .norm(),
            1e-12);
}

TEST(CartesianTrajectory, RefusesNonsense) {
  Eigen::Isometry3d nan = Eigen::Isometry3d::Identity();
  nan.translation().x() = std::nan("");
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_THROW(CartesianTrajectory(here, nan), InputError);
  Eigen::Isometry3d there = here;
  there.translation().x() = 0.1;
  EXPECT_THROW(CartesianTrajectory(here, there, CartesianMotionLimits::at_speed(0.0)), InputError);
}

}  // namespace
}  // namespace binpick
