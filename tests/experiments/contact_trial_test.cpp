#include "experiments/contact_trial.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "models/errors.h"
#include "models/yaml_config.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

constexpr double kHigh = 4000.0;        // N/m
constexpr double kLow = 300.0;          // N/m
constexpr double kSlow = 0.1;           // m/s
constexpr double kFast = 0.8;           // m/s
constexpr double kOvershoot = 0.06;     // m
constexpr double kSurface = 30000.0;    // N/m
constexpr double kThreshold = 15.0;     // N
constexpr double kObserverGain = 50.0;  // 1/s

TrialContext context() { return {TrialSeeds(2012, "fig05", "cell", 0), 0, {}, {}, {}}; }

ContactTrial make_trial(double stiffness, double speed, bool reaction, const std::string& more) {
  ContactTrial trial;
  const std::string text =
      fmt::format("scene: blind_bottle.yaml\nstiffness_z: {}\nspeed: {}\nreaction: {}\n{}",
                  stiffness, speed, reaction ? "on" : "off", more);
  read_yaml_text(text, "test", [&](ConfigVisitor& visitor) { trial.visit(visitor); });
  trial.prepare(BINPICK_SOURCE_DIR "/scenes");
  return trial;
}

const std::string kElastic = "plant: {joints: elastic, motor_friction: 0, torque_errors: off}\n";

std::map<std::string, double> press(double stiffness, double speed, bool reaction,
                                    const std::string& more = kElastic) {
  const TrialRecord record = make_trial(stiffness, speed, reaction, more).run(context());
  EXPECT_EQ(record.outcome, TrialOutcome::kSuccess) << record.note;
  return record.measures;
}

// The springs of impedance and surface in series.
double sustained_force(double stiffness) {
  return kOvershoot * stiffness * kSurface / (stiffness + kSurface);
}

TEST(ContactTrial, ForcesAreOrderedAsPhysicsOrdersThem) {
  const double fast_high = press(kHigh, kFast, false).at("peak_n");
  const double slow_high = press(kHigh, kSlow, false).at("peak_n");
  const double slow_low = press(kLow, kSlow, false).at("peak_n");
  EXPECT_GE(fast_high, slow_high);
  EXPECT_GT(slow_high, slow_low);
}

class ContactCase : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(ContactCase, FirstPeakIsInertialAndSustainedForceElastic) {
  const auto [stiffness, speed] = GetParam();
  const auto measures = press(stiffness, speed, false);
  const double predicted = measures.at("predicted_first_peak_n");
  EXPECT_NEAR(predicted, speed * std::sqrt(4.4 * kSurface), 0.1 * predicted);
  EXPECT_NEAR(measures.at("first_peak_n"), predicted, 0.25 * predicted);
  const double sustained = sustained_force(stiffness);
  EXPECT_NEAR(measures.at("sustained_n"), sustained, 0.05 * sustained);
}

TEST_P(ContactCase, DetectionRaisesNoPeakAndEndsThePressing) {
  const auto [stiffness, speed] = GetParam();
  const auto without = press(stiffness, speed, false);
  const auto with = press(stiffness, speed, true);
  EXPECT_LE(with.at("peak_n"), 1.05 * without.at("peak_n"));
  EXPECT_LT(with.at("sustained_n"), 0.2 * without.at("sustained_n"));
  EXPECT_LE(with.at("detection_latency_s"),
            kThreshold / (kSurface * speed) + 2.0 / kObserverGain + 0.002);
  EXPECT_GT(with.at("detection_latency_s"), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Figure5, ContactCase,
                         ::testing::Values(std::pair(kHigh, kSlow), std::pair(kHigh, kFast),
                                           std::pair(kLow, kSlow), std::pair(kLow, kFast)));

TEST(ContactTrial, SustainedForceFollowsTheStiffnessRatio) {
  const double high = press(kHigh, kFast, false).at("sustained_n");
  const double low = press(kLow, kFast, false).at("sustained_n");
  const double ratio = sustained_force(kHigh) / sustained_force(kLow);
  EXPECT_NEAR(high / low, ratio, 0.1 * ratio);
}

// The world's safety watch ends a trial that breaks a limit. Rigid joints feel the whole blow; the
// stiff arm is thrown back hardest.
TEST(ContactTrial, NoBlowDrivesARigidJointBeyondItsLimits) {
  for (const char* held : {"", "held_mass: 0.5\nheld_length: 0.05\n"}) {
    for (const bool reaction : {false, true}) {
      EXPECT_GT(press(kHigh, kFast, reaction, held).at("first_peak_n"), 250.0);
    }
  }
}

TEST(ContactTrial, AHeldBlockAddsItsMassButNoFalseAlarm) {
  const std::string held = kElastic + "held_mass: 0.5\n";
  const auto empty = press(kLow, kSlow, true);
  const auto loaded = press(kLow, kSlow, true, held);
  EXPECT_NEAR(loaded.at("effective_mass_kg") - empty.at("effective_mass_kg"), 0.5, 0.1);
  EXPECT_GT(loaded.at("detection_latency_s"), 0.0);
  EXPECT_NEAR(loaded.at("contact_speed_m_s"), kSlow, 0.02);
}

TEST(ContactTrial, SameSeedsGiveTheSameBitsWithOrWithoutATrace) {
  const TemporaryFolder folder;
  const std::string noisy = "plant: {joints: elastic}\nhold_time: 0.5\n";
  ContactTrial trial = make_trial(kHigh, kFast, true, noisy);
  TrialContext traced = context();
  traced.trace = folder.path();
  const TrialRecord first = trial.run(context());
  EXPECT_TRUE(identical(first, trial.run(traced)));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "contact.csv"));
  EXPECT_EQ(first.outcome, TrialOutcome::kSuccess) << first.note;
}

TEST(ContactTrial, FirstPeakEndsWhereTheForceFalls) {
  ContactSeries series;
  for (const double force : {0.0, 10.0, 30.0, 25.0, 20.0, 100.0}) {
    ContactSample sample;
    sample.true_force = force;
    series.push_back(sample);
  }
  EXPECT_EQ(first_force_peak(series), 30.0);
  EXPECT_EQ(first_force_peak({}), 0.0);
}

}  // namespace
}  // namespace binpick
