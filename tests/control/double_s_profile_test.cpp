#include "control/double_s_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

constexpr Seed kSeed = 5;

struct Case {
  double distance;
  MotionLimits limits;
};

/// Distances and limits over several decades: all shapes of the profile occur.
std::vector<Case> random_cases(int count) {
  Random random(kSeed);
  std::vector<Case> cases;
  const auto decade = [&] { return std::pow(10.0, random.uniform(-2.0, 2.0)); };
  for (int i = 0; i < count; ++i) cases.push_back({decade(), {decade(), decade(), decade()}});
  return cases;
}

TEST(DoubleSProfile, StaysWithinItsLimitsAndArrives) {
  for (const Case& c : random_cases(500)) {
    const DoubleSProfile profile(c.distance, c.limits);
    const double end = profile.duration();
    double last_acceleration = 0.0;
    constexpr int kSteps = 500;
    for (int k = 0; k <= kSteps; ++k) {
      const PathState state = profile.sample(end * k / kSteps);
      EXPECT_GE(state.velocity, -1e-9 * c.limits.velocity);
      EXPECT_LE(state.velocity, c.limits.velocity * (1.0 + 1e-9));
      EXPECT_LE(std::abs(state.acceleration), c.limits.acceleration * (1.0 + 1e-9));
      if (k > 0) {
        const double jerk = (state.acceleration - last_acceleration) / (end / kSteps);
        EXPECT_LE(std::abs(jerk), c.limits.jerk * (1.0 + 1e-6));
      }
      last_acceleration = state.acceleration;
    }
    EXPECT_NEAR(profile.sample(end * (1.0 - 1e-12)).position, c.distance, 1e-9 * c.distance);
    EXPECT_EQ(profile.sample(end).position, c.distance);
    EXPECT_EQ(profile.sample(-1.0).position, 0.0);
  }
}

TEST(DoubleSProfile, VelocityAndAccelerationAreTheDerivatives) {
  for (const Case& c : random_cases(200)) {
    const DoubleSProfile profile = DoubleSProfile(c.distance, c.limits);
    const double step = 1e-5 * profile.duration();
    for (int k = 1; k < 50; ++k) {
      const double t = profile.duration() * k / 50.0;
      const PathState before = profile.sample(t - step);
      const PathState here = profile.sample(t);
      const PathState after = profile.sample(t + step);
      EXPECT_NEAR((after.position - before.position) / (2.0 * step), here.velocity,
                  1e-6 * c.limits.velocity);
      EXPECT_NEAR((after.velocity - before.velocity) / (2.0 * step), here.acceleration,
                  1e-4 * c.limits.acceleration);
    }
  }
}

TEST(DoubleSProfile, IsSymmetricInTime) {
  for (const Case& c : random_cases(200)) {
    const DoubleSProfile profile(c.distance, c.limits);
    for (int k = 0; k <= 20; ++k) {
      const double t = profile.duration() * k / 40.0;
      const PathState early = profile.sample(t);
      const PathState late = profile.sample(profile.duration() - t);
      EXPECT_NEAR(early.position + late.position, c.distance, 1e-9 * c.distance);
      EXPECT_NEAR(early.velocity, late.velocity, 1e-9 * c.limits.velocity);
    }
  }
}

// The known closed forms of the four shapes.
TEST(DoubleSProfile, TakesTheLeastPossibleTime) {
  constexpr double kLoose = 1e6;
  // Jerk alone: four equal phases.
  EXPECT_NEAR(DoubleSProfile(2.0, {kLoose, kLoose, 1.0}).duration(), 4.0, 1e-9);
  // Acceleration alone (nearly): bang-bang.
  EXPECT_NEAR(DoubleSProfile(1.0, {kLoose, 4.0, 1e9}).duration(), 1.0, 1e-6);
  // Velocity alone (nearly).
  EXPECT_NEAR(DoubleSProfile(3.0, {2.0, 1e6, 1e12}).duration(), 1.5, 1e-5);
  // All three reached: D / v + v / a + a / j.
  EXPECT_NEAR(DoubleSProfile(10.0, {2.0, 4.0, 16.0}).duration(), 5.0 + 0.5 + 0.25, 1e-12);
}

TEST(DoubleSProfile, ReachesSomeLimitAllTheTime) {
  // The fastest motion under the limits is at one of them in every phase.
  for (const Case& c : random_cases(200)) {
    const DoubleSProfile profile(c.distance, c.limits);
    const auto breaks = profile.breakpoints();
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
      const double span = breaks[k + 1] - breaks[k];
      if (span < 1e-6 * profile.duration()) continue;
      const PathState a = profile.sample(breaks[k] + 0.25 * span);
      const PathState b = profile.sample(breaks[k] + 0.75 * span);
      const double jerk = std::abs(b.acceleration - a.acceleration) / (0.5 * span);
      const double use =
          std::max({jerk / c.limits.jerk, std::abs(a.acceleration) / c.limits.acceleration,
                    a.velocity / c.limits.velocity});
      EXPECT_NEAR(use, 1.0, 1e-6) << "phase " << k;
    }
  }
}

TEST(DoubleSProfile, LongerWaysAndTighterLimitsTakeLonger) {
  for (const Case& c : random_cases(200)) {
    const double duration = DoubleSProfile(c.distance, c.limits).duration();
    EXPECT_GT(DoubleSProfile(1.01 * c.distance, c.limits).duration(), duration);
    MotionLimits tighter = c.limits;
    tighter.jerk *= 0.9;
    EXPECT_GT(DoubleSProfile(c.distance, tighter).duration(), duration);
  }
}

TEST(DoubleSProfile, AStretchedMotionHasTheWantedDurationAndScaledDerivatives) {
  const DoubleSProfile profile(0.7, {0.5, 2.0, 10.0});
  const DoubleSProfile slower = profile.stretched_to(3.0 * profile.duration());
  EXPECT_NEAR(slower.duration(), 3.0 * profile.duration(), 1e-12);
  for (int k = 0; k <= 20; ++k) {
    const double t = profile.duration() * k / 20.0;
    EXPECT_NEAR(slower.sample(3.0 * t).position, profile.sample(t).position, 1e-12);
    EXPECT_NEAR(slower.sample(3.0 * t).velocity, profile.sample(t).velocity / 3.0, 1e-12);
    EXPECT_NEAR(slower.sample(3.0 * t).acceleration, profile.sample(t).acceleration / 9.0, 1e-9);
  }
  EXPECT_EQ(profile.stretched_to(0.0).duration(), profile.duration());
}

TEST(DoubleSProfile, NoDistanceTakesNoTime) {
  const DoubleSProfile profile(0.0, {1.0, 1.0, 1.0});
  EXPECT_EQ(profile.duration(), 0.0);
  EXPECT_EQ(profile.sample(0.5).position, 0.0);
  EXPECT_EQ(DoubleSProfile().sample(1.0).velocity, 0.0);
}

TEST(DoubleSProfile, RefusesMeaninglessLimits) {
  EXPECT_THROW(DoubleSProfile(1.0, {0.0, 1.0, 1.0}), InputError);
  EXPECT_THROW(DoubleSProfile(1.0, {1.0, -1.0, 1.0}), InputError);
  EXPECT_THROW(DoubleSProfile(1.0, {1.0, 1.0, std::nan("")}), InputError);
  EXPECT_THROW(DoubleSProfile(-1.0, {1.0, 1.0, 1.0}), InputError);
}

}  // namespace
}  // namespace binpick
