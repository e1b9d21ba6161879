#include "experiments/success_gate.h"

#include <gtest/gtest.h>

#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

using Verdict = SuccessGate::Verdict;

struct Outcome {
  double failed = 0.0;  ///< share of the streams
  double trials = 0.0;  ///< mean length
};

/// Feeds gates with simulated Bernoulli streams of rate `p`.
Outcome simulate(double expected, double p, int streams, Seed seed) {
  Random random(seed);
  Outcome outcome;
  for (int i = 0; i < streams; ++i) {
    SuccessGate gate(expected);
    while (gate.verdict() == Verdict::kOpen) gate.add(random.uniform() < p);
    outcome.failed += gate.verdict() == Verdict::kFailed ? 1.0 : 0.0;
    outcome.trials += static_cast<double>(gate.seen().trials);
  }
  return {outcome.failed / streams, outcome.trials / streams};
}

class SuccessGates : public ::testing::TestWithParam<double> {};

// 20000 streams tell 1 % from 1.3 % and 90 % from 89 % at four standard errors.
constexpr int kStreams = 20'000;

TEST_P(SuccessGates, RaiseAFalseAlarmInAtMostOnePercent) {
  const double expected = GetParam();
  for (const double better : {0.0, 0.5 * (1.0 - expected)}) {
    const Outcome outcome = simulate(expected, expected + better, kStreams, 1);
    EXPECT_LE(outcome.failed, 0.013) << better;
    EXPECT_LT(outcome.trials, 60.0) << better;
  }
}

TEST_P(SuccessGates, SeeADropOfFifteenPointsInNineOfTenCases) {
  const double expected = GetParam();
  for (const double deeper : {0.0, 0.1}) {
    const Outcome outcome = simulate(expected, expected - 0.15 - deeper, kStreams, 2);
    EXPECT_GE(outcome.failed, 0.89) << deeper;
    EXPECT_LT(outcome.trials, 100.0) << deeper;
  }
}

INSTANTIATE_TEST_SUITE_P(SuccessGate, SuccessGates,
                         ::testing::Values(0.5, 0.667, 0.8, 0.9, 0.95, 0.98));

TEST(SuccessGate, PassesAndFailsAfterTheTrialsThatItsRatiosAskFor) {
  // log(0.1) / log(0.80 / 0.95) = 13.4 and log(100) / log(0.20 / 0.05) = 3.3.
  SuccessGate sound(0.95);
  for (int i = 0; i < 13; ++i) EXPECT_EQ(sound.add(true), Verdict::kOpen);
  EXPECT_EQ(sound.add(true), Verdict::kPassed);
  EXPECT_EQ(sound.add(false), Verdict::kPassed);
  EXPECT_EQ(sound.seen().trials, 14);
  SuccessGate broken(0.95);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(broken.add(false), Verdict::kOpen);
  EXPECT_EQ(broken.add(false), Verdict::kFailed);
}

TEST(SuccessGate, RefusesRatesWithoutMeaning) {
  EXPECT_THROW(SuccessGate(1.0), InputError);
  EXPECT_THROW(SuccessGate(0.15), InputError);
  EXPECT_THROW(SuccessGate(0.9, 0.0), InputError);
}

}  // namespace
}  // namespace binpick
