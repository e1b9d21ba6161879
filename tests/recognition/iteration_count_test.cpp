#include "recognition/iteration_count.h"

#include <gtest/gtest.h>

#include <cmath>

#include "models/random.h"

namespace binpick {
namespace {

TEST(IterationCount, FollowsEquationEleven) {
  // N = -n ln(1 - P_S) / (m K C) with n = 5000, m = 500, K = 0.4, C = 1/4: 10 * 4.60517 / 0.1.
  SamplingOdds odds{5000.0, 500.0, 0.4, 0.25, 0.99};
  EXPECT_EQ(iteration_count(odds), 461.0);
  odds.scene_points *= 2.0;  // linear in n
  EXPECT_EQ(iteration_count(odds), 922.0);
  odds.success_probability = 0.9;
  EXPECT_EQ(iteration_count(odds), std::ceil(20.0 * std::log(10.0) / 0.1));
}

TEST(IterationCount, ReachesTheSuccessProbability) {
  // A draw hits with probability P_M = (m / n) K C; the share of runs with a hit within N draws is
  // P_S up to the Taylor approximation, which errs on the safe side.
  const SamplingOdds odds{400.0, 100.0, 0.4, 0.25, 0.95};
  const double hit = 100.0 / 400.0 * 0.4 * 0.25;
  const auto draws = static_cast<int>(iteration_count(odds));
  constexpr int kRuns = 20000;
  int successes = 0;
  for (int run = 0; run < kRuns; ++run) {
    Random random(derive_seed(99, static_cast<std::uint64_t>(run)));
    bool found = false;
    for (int i = 0; i < draws && !found; ++i) found = random.uniform() < hit;
    if (found) ++successes;
  }
  const double share = static_cast<double>(successes) / kRuns;
  const double three_sigma = 3.0 * std::sqrt(0.95 * 0.05 / kRuns);
  EXPECT_GT(share, 0.95 - three_sigma);
  EXPECT_LT(share, 0.96 + three_sigma);
}

}  // namespace
}  // namespace binpick
