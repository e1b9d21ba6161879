#include "experiments/stopping_rule.h"

#include <gtest/gtest.h>

#include <cmath>

#include "coin_experiment.h"
#include "experiments/trial_quota.h"
#include "models/random.h"

namespace binpick {
namespace {

/// Draws trials until the plan has enough.
Proportion sample(const SequentialPlan& plan, double p, Random& random) {
  std::vector<bool> successes;
  while (plan.size(successes) > std::ssize(successes)) successes.push_back(random.uniform() < p);
  Proportion proportion;
  for (const bool success : successes) {
    ++proportion.trials;
    proportion.successes += success ? 1 : 0;
  }
  return proportion;
}

struct PlanCase {
  StoppingRule rule;
  std::int64_t most;
};

class SequentialPlans : public ::testing::TestWithParam<PlanCase> {};

TEST_P(SequentialPlans, CoverAsTheySayInSimulatedStreams) {
  const auto& [rule, most] = GetParam();
  const SequentialPlan plan(rule, most);
  constexpr int kStreams = 2000;
  Random random(31);
  for (const double p : {0.05, 0.2, 0.5, 0.667, 0.9, 0.98}) {
    int covered = 0;
    for (int i = 0; i < kStreams; ++i) {
      const Interval interval = plan.interval(sample(plan, p, random));
      covered += interval.low <= p && p <= interval.high ? 1 : 0;
    }
    const double rate = double(covered) / kStreams;
    const double error = std::sqrt(0.05 * 0.95 / kStreams);
    EXPECT_GT(rate, 0.95 - 3.0 * error) << p;
    EXPECT_NEAR(rate, plan.coverage(p), 4.0 * error) << p;
  }
}

TEST_P(SequentialPlans, CoverEveryRate) {
  const auto& [rule, most] = GetParam();
  const SequentialPlan plan(rule, most);
  for (int i = 1; i < 2000; ++i) {
    const double p = i / 2000.0;
    EXPECT_GE(plan.coverage(p), 0.95 - 1e-9) << p;
    EXPECT_NEAR(plan.coverage(p), plan.coverage(1.0 - p), 1e-9);
    EXPECT_LE(plan.coverage(p), 1.0 + 1e-9);
  }
}

TEST_P(SequentialPlans, StopWhenTheIntervalIsNarrowAndNotBefore) {
  const auto& [rule, most] = GetParam();
  const SequentialPlan plan(rule, most);
  Random random(5);
  for (const double p : {0.02, 0.5, 0.9}) {
    for (int i = 0; i < 100; ++i) {
      const Proportion at_end = sample(plan, p, random);
      const Interval interval = plan.interval(at_end);
      EXPECT_TRUE(at_end.trials % rule.block == 0 || at_end.trials == most);
      EXPECT_TRUE(at_end.trials == most ||
                  interval.high - interval.low <= 2.0 * rule.half_width + 1e-12);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(StoppingRule, SequentialPlans,
                         ::testing::Values(PlanCase{{0.05, 50}, 600}, PlanCase{{0.1, 10}, 85},
                                           PlanCase{{0.08, 1}, 150}));

TEST(StoppingRule, CoverageOfASingleLookIsABinomialSum) {
  const SequentialPlan plan({0.5, 100}, 100);
  for (const double p : {0.01, 0.3, 0.5}) {
    double covered = 0.0;
    for (std::int64_t k = 0; k <= 100; ++k) {
      const Interval interval = plan.interval({k, 100});
      if (p < interval.low || p > interval.high) continue;
      const auto successes = static_cast<double>(k);
      covered += std::exp(std::lgamma(101.0) - std::lgamma(successes + 1.0) -
                          std::lgamma(101.0 - successes) + successes * std::log(p) +
                          (100.0 - successes) * std::log1p(-p));
    }
    EXPECT_NEAR(plan.coverage(p), covered, 1e-10);
  }
}

TEST(StoppingRule, SizeDoesNotDependOnWhatComesAfterTheStop) {
  const SequentialPlan plan({0.1, 10}, 100);
  std::vector<bool> successes(30, true);
  const std::int64_t stop = plan.size(successes);
  ASSERT_LE(stop, 30);
  successes.resize(100, false);
  EXPECT_EQ(plan.size(successes), stop);
  EXPECT_EQ(plan.size({}), 10);
}

class Quota : public ::testing::Test {
 protected:
  Quota()
      : experiment_(Experiment::from_text(kCoinYaml + "stopping: {half_width: 0.15, block: 10}\n",
                                          "test", "/", coin_registry())) {}

  void toss(const std::vector<Job>& jobs) {
    for (const Job& job : jobs) {
      const Cell& cell = experiment_.cells()[job.cell];
      const auto kind = experiment_.make_kind();
      experiment_.assign(cell, *kind);
      trials_[{cell.key, job.trial}] = {
          kind->run({experiment_.seeds(cell, job.trial), job.trial, {}, {}, {}}), 0.1};
    }
  }

  Experiment experiment_;
  TrialTable trials_;
};

TEST_F(Quota, AsksForBlocksUntilEveryCellHasEnough) {
  const TrialQuota quota(experiment_);
  EXPECT_EQ(quota.expected(trials_), experiment_.job_count());
  for (auto jobs = quota.missing(trials_); !jobs.empty(); jobs = quota.missing(trials_)) {
    for (const Job& job : jobs) EXPECT_EQ(job.trial / 10, jobs.front().trial / 10);
    toss(jobs);
  }
  EXPECT_EQ(quota.expected(trials_), std::ssize(trials_));
  EXPECT_EQ(quota.select(trials_).size(), trials_.size());
}

TEST_F(Quota, LeavesOutWhatALargerRunLeftBehind) {
  const TrialQuota quota(experiment_);
  while (!quota.missing(trials_).empty()) toss(quota.missing(trials_));
  const std::size_t enough = trials_.size();
  for (std::int64_t i = 0; i < experiment_.job_count(); ++i) toss({experiment_.job(i)});
  EXPECT_EQ(quota.select(trials_).size(), enough);
  EXPECT_TRUE(quota.missing(trials_).empty());
}

TEST_F(Quota, AHoleIsFilledBeforeTheNextLook) {
  const TrialQuota quota(experiment_);
  toss(quota.missing(trials_));
  const TrialKey hole{experiment_.cells()[2].key, 3};
  trials_.erase(hole);
  const std::vector<Job> jobs = quota.missing(trials_);
  EXPECT_TRUE(std::any_of(jobs.begin(), jobs.end(),
                          [](const Job& job) { return job.cell == 2 && job.trial == 3; }));
  EXPECT_TRUE(std::none_of(jobs.begin(), jobs.end(),
                           [](const Job& job) { return job.cell == 2 && job.trial >= 10; }));
}

}  // namespace
}  // namespace binpick
