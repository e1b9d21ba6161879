#include "experiments/proportions.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "models/random.h"

namespace binpick {
namespace {

double binomial_tail(std::int64_t n, std::int64_t from, double p) {
  double tail = 0.0;
  for (std::int64_t k = from; k <= n; ++k) {
    const double log_choose =
        std::lgamma(double(n) + 1) - std::lgamma(double(k) + 1) - std::lgamma(double(n - k) + 1);
    tail += std::exp(log_choose + double(k) * std::log(p) + double(n - k) * std::log1p(-p));
  }
  return tail;
}

TEST(Proportions, IncompleteBetaIsTheBinomialTail) {
  for (const std::int64_t n : {1, 10, 137, 1000}) {
    for (const double p : {0.001, 0.2, 0.5, 0.93}) {
      for (const std::int64_t k : {std::int64_t{1}, n / 2 + 1, n}) {
        EXPECT_NEAR(regularized_incomplete_beta(double(k), double(n - k + 1), p),
                    binomial_tail(n, k, p), 1e-10)
            << n << " " << k << " " << p;
      }
    }
  }
}

TEST(Proportions, UpperGammaIsTheChiSquareTail) {
  // Q(1, x) = exp(-x); chi-square with 8 degrees of freedom beyond 15.507 has 5 %.
  EXPECT_NEAR(regularized_upper_gamma(1.0, 0.3), std::exp(-0.3), 1e-14);
  EXPECT_NEAR(regularized_upper_gamma(1.0, 7.0), std::exp(-7.0), 1e-15);
  EXPECT_NEAR(regularized_upper_gamma(4.0, 15.50731306 / 2.0), 0.05, 1e-9);
  EXPECT_NEAR(regularized_upper_gamma(0.5, 3.841458821 / 2.0), 0.05, 1e-9);
  EXPECT_EQ(regularized_upper_gamma(4.0, 0.0), 1.0);
}

struct PublishedInterval {
  Proportion proportion;
  double low, high;
};

// Newcombe, Statistics in Medicine 17 (1998), table I: methods 3 (score) and 5 (exact).
TEST(Proportions, WilsonAgreesWithNewcombe) {
  for (const auto& [proportion, low, high] :
       {PublishedInterval{{81, 263}, 0.2553, 0.3662}, PublishedInterval{{15, 148}, 0.0624, 0.1605},
        PublishedInterval{{0, 20}, 0.0, 0.1611}, PublishedInterval{{1, 29}, 0.0061, 0.1718}}) {
    const Interval interval = wilson_interval(proportion);
    EXPECT_NEAR(interval.low, low, 5e-5);
    EXPECT_NEAR(interval.high, high, 5e-5);
  }
}

bool covers(const Interval& interval, double rate) {
  return interval.low <= rate && rate <= interval.high;
}

TEST(Proportions, ClustersOfOneTrialAreIndependentTrials) {
  std::vector<Proportion> clusters(40, {1, 1});
  clusters.resize(60, {0, 1});
  const Interval clustered = clustered_interval(clusters);
  const Interval wilson = wilson_interval({40, 60});
  EXPECT_EQ(clustered.low, wilson.low);
  EXPECT_EQ(clustered.high, wilson.high);
}

TEST(Proportions, TrialsThatAllFollowTheirClusterSayNoMoreThanOne) {
  std::vector<Proportion> clusters(400, {9, 9});
  clusters.resize(600, {0, 9});
  const Interval clustered = clustered_interval(clusters);
  const Interval wilson = wilson_interval({400, 600});
  EXPECT_NEAR(clustered.low, wilson.low, 1e-3);
  EXPECT_NEAR(clustered.high, wilson.high, 1e-3);
  // Without a failure there is no variance to go by.
  EXPECT_EQ(clustered_interval(std::vector<Proportion>(200, {9, 9})).low,
            wilson_interval({200, 200}).low);
}

TEST(Proportions, ClusteredIntervalsHoldWhereIndependentOnesDoNot) {
  // Nine cells see the same draw, as in Table 1: each succeeds where it lies below the cell's rate.
  constexpr std::array<double, 9> kRates = {1.0, 0.85, 0.74, 0.73, 0.6, 0.54, 0.54, 0.5, 0.48};
  double mean = 0.0;
  for (const double rate : kRates) mean += rate / 9.0;
  Random random(7);
  int clustered = 0;
  int independent = 0;
  constexpr int kRuns = 1000;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Proportion> clusters;
    Proportion all;
    for (int i = 0; i < 60; ++i) {
      const double draw = random.uniform();
      Proportion cluster{0, 9};
      for (const double rate : kRates) cluster.successes += draw < rate ? 1 : 0;
      clusters.push_back(cluster);
      all = all + cluster;
    }
    clustered += covers(clustered_interval(clusters), mean) ? 1 : 0;
    independent += covers(wilson_interval(all), mean) ? 1 : 0;
  }
  EXPECT_GE(clustered, 0.93 * kRuns);
  EXPECT_LE(independent, 0.75 * kRuns);
}

TEST(Proportions, ClopperPearsonAgreesWithNewcombe) {
  for (const auto& [proportion, low, high] :
       {PublishedInterval{{81, 263}, 0.2527, 0.3676}, PublishedInterval{{15, 148}, 0.0578, 0.1617},
        PublishedInterval{{0, 20}, 0.0, 0.1684}, PublishedInterval{{1, 29}, 0.0009, 0.1776}}) {
    const Interval interval = clopper_pearson_interval(proportion);
    EXPECT_NEAR(interval.low, low, 5e-5);
    EXPECT_NEAR(interval.high, high, 5e-5);
  }
}

TEST(Proportions, IntervalsAtTheEndsTouchThem) {
  EXPECT_EQ(wilson_interval({10, 10}).high, 1.0);
  EXPECT_EQ(wilson_interval({0, 10}).low, 0.0);
  EXPECT_EQ(clopper_pearson_interval({10, 10}).high, 1.0);
  EXPECT_EQ(clopper_pearson_interval({0, 10}).low, 0.0);
  EXPECT_EQ(wilson_interval({0, 0}).low, 0.0);
  EXPECT_EQ(wilson_interval({0, 0}).high, 1.0);
  EXPECT_EQ(clopper_pearson_interval({0, 0}).high, 1.0);
}

/// Probability that the interval of `n` trials contains the true rate.
template <class MakeInterval>
double coverage(MakeInterval make_interval, std::int64_t n, double rate) {
  double covered = 0.0;
  for (std::int64_t k = 0; k <= n; ++k) {
    const double probability = binomial_tail(n, k, rate) - binomial_tail(n, k + 1, rate);
    if (make_interval(Proportion{k, n}).contains(rate)) covered += probability;
  }
  return covered;
}

TEST(Proportions, ClopperPearsonCoversAtLeastNinetyFivePercent) {
  for (double rate = 0.03; rate < 1.0; rate += 0.031) {
    EXPECT_GE(coverage(clopper_pearson_interval, 40, rate), 0.95) << rate;
  }
}

TEST(Proportions, WilsonCoversNinetyFivePercentOnAverage) {
  double sum = 0.0;
  int count = 0;
  for (double rate = 0.05; rate < 0.96; rate += 0.007, ++count) {
    sum += coverage(wilson_interval, 60, rate);
  }
  EXPECT_NEAR(sum / count, 0.95, 0.005);
}

TEST(Proportions, FisherAgreesWithPublishedValues) {
  // Fisher's tea-tasting lady, 3 of 4 right: p = 0.4857; Table 1 of IJRR 2012, best against worst.
  EXPECT_NEAR(fisher_exact_p({3, 4}, {1, 4}), 0.48571428571, 1e-9);
  EXPECT_NEAR(fisher_exact_p({9, 10}, {4, 10}), 0.0573, 5e-5);
  EXPECT_NEAR(fisher_exact_p({9, 10}, {5, 10}), 0.1409, 5e-5);
  EXPECT_NEAR(fisher_exact_p({58, 60}, {56, 60}), 0.6794, 5e-4);
  EXPECT_EQ(fisher_exact_p({5, 5}, {7, 7}), 1.0);
}

TEST(Proportions, McNemarIsATwoSidedCoinTest) {
  EXPECT_EQ(mcnemar_exact_p(0, 0), 1.0);
  EXPECT_EQ(mcnemar_exact_p(4, 4), 1.0);
  // 2 (1 + 10) / 2^10
  EXPECT_NEAR(mcnemar_exact_p(1, 9), 22.0 / 1024.0, 1e-12);
  EXPECT_NEAR(mcnemar_exact_p(9, 1), 22.0 / 1024.0, 1e-12);
}

}  // namespace
}  // namespace binpick
