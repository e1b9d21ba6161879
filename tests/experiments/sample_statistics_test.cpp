#include "experiments/sample_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace binpick {
namespace {

TEST(SampleStatistics, QuantilesInterpolateAndTheirIntervalsHoldTheTruth) {
  EXPECT_DOUBLE_EQ(estimate_quantile({3.0, 1.0, 2.0}, 0.5).value, 2.0);
  EXPECT_DOUBLE_EQ(estimate_quantile({1.0, 2.0}, 0.5).value, 1.5);
  EXPECT_DOUBLE_EQ(estimate_quantile({}, 0.5).value, 0.0);
  int covered = 0;
  for (Seed seed = 0; seed < 400; ++seed) {
    Random draw(seed);
    std::vector<double> values(101);
    for (double& value : values) value = draw.uniform();
    covered += estimate_quantile(values, 0.5).interval.contains(0.5) ? 1 : 0;
  }
  EXPECT_GE(covered, 370);
  EXPECT_LE(covered, 395);
}

TEST(SampleStatistics, PoissonIntervalMatchesTheExactOne) {
  // Exact limits of Garwood (1936).
  EXPECT_NEAR(poisson_interval(0.0).high, 3.689, 0.001);
  EXPECT_NEAR(poisson_interval(5.0).low, 1.623, 0.02);
  EXPECT_NEAR(poisson_interval(5.0).high, 11.668, 0.02);
  EXPECT_NEAR(poisson_interval(50.0).low, 37.11, 0.05);
  EXPECT_NEAR(poisson_interval(50.0).high, 65.92, 0.05);
}

TEST(SampleStatistics, LineThroughPointsOfALineExplainsAll) {
  const std::vector<double> x{1.0, 2.0, 4.0};
  const LinearFit exact = fit_line(x, std::vector{5.0, 8.0, 14.0});
  EXPECT_NEAR(exact.intercept, 2.0, 1e-12);
  EXPECT_NEAR(exact.slope, 3.0, 1e-12);
  EXPECT_NEAR(exact.r_squared, 1.0, 1e-12);
  EXPECT_NEAR(fit_line(std::vector{0.0, 1.0, 2.0}, std::vector{0.0, 1.0, 0.0}).r_squared, 0.0,
              1e-12);
}

TEST(SampleStatistics, RatioOfMediansPairsItsSamples) {
  std::vector<double> slow;
  std::vector<double> fast;
  Random draw(3);
  for (int i = 0; i < 40; ++i) {
    fast.push_back(1.0 + 0.1 * draw.uniform());
    slow.push_back(1.9 * fast.back());
  }
  const RatioEstimate ratio = median_ratio(slow, fast, 1);
  EXPECT_NEAR(ratio.value, 1.9, 1e-9);
  EXPECT_NEAR(ratio.interval.low, 1.9, 1e-9);
  EXPECT_NEAR(ratio.interval.high, 1.9, 1e-9);
}

}  // namespace
}  // namespace binpick
