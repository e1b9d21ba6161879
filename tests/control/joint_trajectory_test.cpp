#include "control/joint_trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/test_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

using testing::degrees;
using testing::random_posture;

constexpr Seed kSeed = 11;
constexpr double kTick = 0.001;

JointLimits limits() { return testing::make_arm().limits(); }

std::vector<JointVector> random_waypoints(Random& random, std::size_t count) {
  std::vector<JointVector> waypoints;
  for (std::size_t i = 0; i < count; ++i) {
    waypoints.push_back(random_posture(random, limits(), random.uniform(0.05, 0.9)));
  }
  return waypoints;
}

double distance_to_path(const JointVector& q, const std::vector<JointVector>& waypoints) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 1 < waypoints.size(); ++k) {
    const JointVector along = waypoints[k + 1] - waypoints[k];
    const double t = std::clamp((q - waypoints[k]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    smallest = std::min(smallest, (waypoints[k] + t * along - q).norm());
  }
  return smallest;
}

TEST(JointTrajectory, RespectsSpeedAccelerationAndJerkLimits) {
  Random random(kSeed);
  const JointLimits joint = limits();
  for (int i = 0; i < 60; ++i) {
    JointMotionOptions options;
    options.speed = random.uniform(0.1, 1.0);
    options.blend = i % 3 == 0 ? 1.0 : random.uniform();
    const JointTrajectory trajectory(random_waypoints(random, 2 + random.index(4)), joint, options);
    const JointVector acceleration = joint.velocity / options.acceleration_time;
    JointVector last = JointVector::Zero();
    for (double t = 0.0; t < trajectory.duration(); t += kTick) {
      const JointTarget sample = trajectory.sample(t);
      EXPECT_LE((sample.qd.cwiseAbs() - options.speed * joint.velocity).maxCoeff(), 1e-9);
      EXPECT_LE((sample.qdd.cwiseAbs() - acceleration).maxCoeff(), 1e-9);
      const JointVector jerk = (sample.qdd - last) / kTick;
      EXPECT_LE((jerk.cwiseAbs() - 2.0 * acceleration / options.jerk_time).maxCoeff(), 1e-6);
      last = sample.qdd;
    }
  }
}

TEST(JointTrajectory, VelocityAndAccelerationAreTheDerivatives) {
  Random random(kSeed);
  for (int i = 0; i < 20; ++i) {
    const JointTrajectory trajectory(random_waypoints(random, 4), limits());
    constexpr double kStep = 1e-5;
    for (double t = kStep; t < trajectory.duration() - kStep; t += 0.013) {
      const JointTarget before = trajectory.sample(t - kStep);
      const JointTarget here = trajectory.sample(t);
      const JointTarget after = trajectory.sample(t + kStep);
      EXPECT_LT(((after.q - before.q) / (2.0 * kStep) - here.qd).norm(), 1e-6);
      EXPECT_LT(((after.qd - before.qd) / (2.0 * kStep) - here.qdd).norm(), 1e-2);
    }
  }
}

TEST(JointTrajectory, StartsAndEndsAtRestAtItsEnds) {
  Random random(kSeed);
  const std::vector<JointVector> waypoints = random_waypoints(random, 4);
  const JointTrajectory trajectory(waypoints, limits());
  for (const double t : {-1.0, 0.0}) {
    EXPECT_EQ(trajectory.sample(t).q, waypoints.front());
    EXPECT_EQ(trajectory.sample(t).qd, JointVector::Zero());
  }
  for (const double t : {trajectory.duration(), trajectory.duration() + 1.0}) {
    EXPECT_EQ(trajectory.sample(t).q, waypoints.back());
    EXPECT_EQ(trajectory.sample(t).qd, JointVector::Zero());
  }
  EXPECT_LT((trajectory.sample(trajectory.duration() - 1e-9).q - waypoints.back()).norm(), 1e-9);
}

TEST(JointTrajectory, AllJointsShareOneClock) {
  Random random(kSeed);
  const std::vector<JointVector> ends = random_waypoints(random, 2);
  const JointTrajectory trajectory(ends, limits());
  for (double t = 0.0; t < trajectory.duration(); t += 0.01) {
    const JointVector done = (trajectory.sample(t).q - ends[0]).cwiseQuotient(ends[1] - ends[0]);
    EXPECT_LT(done.maxCoeff() - done.minCoeff(), 1e-9);
  }
}

TEST(JointTrajectory, KeepsTheJerkLimitWhereNothingOverlaps) {
  Random random(kSeed);
  const JointLimits joint = limits();
  const JointMotionOptions options;
  const JointTrajectory trajectory(random_waypoints(random, 2), joint, options);
  const JointVector allowed = joint.velocity / options.acceleration_time / options.jerk_time;
  double largest = 0.0;
  JointVector last = JointVector::Zero();
  for (double t = 0.0; t < trajectory.duration(); t += kTick) {
    const JointVector qdd = trajectory.sample(t).qdd;
    largest =
        std::max(largest, ((qdd - last) / kTick).cwiseAbs().cwiseQuotient(allowed).maxCoeff());
    last = qdd;
  }
  EXPECT_NEAR(largest, 1.0, 1e-6);
}

TEST(JointTrajectory, UsesAtLeastOneLimitFully) {
  const JointLimits joint = limits();
  JointMotionOptions options;
  options.speed = 1.0;
  const JointTrajectory trajectory({JointVector::Zero(), degrees(150, 20, 0, 10, 0, 0, 30)}, joint,
                                   options);
  double fastest = 0.0;
  for (double t = 0.0; t < trajectory.duration(); t += kTick) {
    fastest = std::max(fastest, trajectory.sample(t).qd.cwiseQuotient(joint.velocity).maxCoeff());
  }
  EXPECT_NEAR(fastest, 1.0, 1e-9);
}

TEST(JointTrajectory, WithoutBlendingItStopsAtEveryWaypoint) {
  Random random(kSeed);
  const std::vector<JointVector> waypoints = random_waypoints(random, 4);
  JointMotionOptions options;
  options.blend = 0.0;
  const JointTrajectory trajectory(waypoints, limits(), options);
  std::size_t reached = 1;
  double off_path = 0.0;
  for (double t = 0.0; t <= trajectory.duration() + kTick && reached < waypoints.size();
       t += kTick) {
    const JointTarget sample = trajectory.sample(t);
    off_path = std::max(off_path, distance_to_path(sample.q, waypoints));
    if ((sample.q - waypoints[reached]).norm() < 1e-4 && sample.qd.norm() < 1e-2) ++reached;
  }
  EXPECT_EQ(reached, waypoints.size());
  EXPECT_LT(off_path, 1e-7);
}

TEST(JointTrajectory, BlendingIsFasterAndCutsCornersOnlyALittle) {
  Random random(kSeed);
  for (int i = 0; i < 20; ++i) {
    const std::vector<JointVector> waypoints = random_waypoints(random, 4);
    JointMotionOptions options;
    options.blend = 0.0;
    const double stopping = JointTrajectory(waypoints, limits(), options).duration();
    options.blend = 0.5;
    const JointTrajectory blended(waypoints, limits(), options);
    EXPECT_LT(blended.duration(), stopping);
    for (double t = 0.0; t < blended.duration(); t += 0.005) {
      EXPECT_LT(distance_to_path(blended.sample(t).q, waypoints), 0.06);
    }
  }
}

TEST(JointTrajectory, AReversalWithFullBlendingStaysWithinTheLimits) {
  // Braking and setting off again add up here: they may overlap only as far as the limit allows.
  const JointVector there = degrees(40, 0, 0, 0, 0, 0, 0);
  JointMotionOptions options;
  options.blend = 1.0;
  const JointLimits joint = limits();
  const JointTrajectory trajectory({JointVector::Zero(), there, JointVector::Zero()}, joint,
                                   options);
  double largest = 0.0;
  for (double t = 0.0; t < trajectory.duration(); t += 1e-4) {
    largest = std::max(largest, std::abs(trajectory.sample(t).qdd[0]));
  }
  EXPECT_NEAR(largest, joint.velocity[0] / options.acceleration_time, 1e-6);
}

TEST(JointTrajectory, EqualWaypointsAreMerged) {
  const JointVector a = JointVector::Zero();
  const JointVector b = degrees(10, 20, 0, 0, 0, 0, 0);
  const JointTrajectory plain({a, b}, limits());
  const JointTrajectory repeated({a, a, b, b}, limits());
  EXPECT_EQ(plain.duration(), repeated.duration());
  EXPECT_EQ(JointTrajectory({a, a}, limits()).duration(), 0.0);
  EXPECT_EQ(JointTrajectory(b).sample(3.0).q, b);
}

TEST(JointTrajectory, CanBeStretched) {
  const JointTrajectory plain({JointVector::Zero(), degrees(10, 20, 0, 0, 0, 0, 0)}, limits());
  const JointTrajectory slower = plain.stretched_to(2.0 * plain.duration());
  EXPECT_NEAR(slower.duration(), 2.0 * plain.duration(), 1e-12);
  const double t = 0.4 * plain.duration();
  EXPECT_LT((slower.sample(2.0 * t).q - plain.sample(t).q).norm(), 1e-12);
  EXPECT_LT((2.0 * slower.sample(2.0 * t).qd - plain.sample(t).qd).norm(), 1e-12);
}

TEST(JointTrajectory, ComesBackFromBeyondALimitButNeverGoesThere) {
  const JointVector beyond = degrees(0, 121, 0, 0, 0, 0, 0);
  const JointVector inside = degrees(0, 100, 0, 0, 0, 0, 0);
  EXPECT_NO_THROW(JointTrajectory({beyond, inside}, limits()));
  EXPECT_THROW(JointTrajectory({inside, beyond}, limits()), InputError);
}

TEST(JointTrajectory, RefusesNonsense) {
  const JointVector zero = JointVector::Zero();
  JointVector nan = zero;
  nan[3] = std::nan("");
  EXPECT_THROW(JointTrajectory({}, limits()), InputError);
  EXPECT_THROW(JointTrajectory({nan, zero}, limits()), InputError);
  EXPECT_THROW(JointTrajectory({zero, nan}, limits()), InputError);
  JointMotionOptions options;
  options.speed = 1.5;
  EXPECT_THROW(JointTrajectory({zero, zero}, limits(), options), InputError);
}

}  // namespace
}  // namespace binpick
