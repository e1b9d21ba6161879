#include "experiments/stiffness_claims.h"

#include <gtest/gtest.h>

#include "coin_experiment.h"
#include "experiments/table_comparison.h"
#include "models/random.h"

namespace binpick {
namespace {

using Verdict = StiffnessClaim::Verdict;

StiffnessOutcomes draw_outcomes(const std::array<double, 9>& rates, std::size_t trials, Seed seed) {
  StiffnessOutcomes outcomes;
  for (std::size_t cell = 0; cell < 9; ++cell) {
    Random random(derive_seed(seed, cell));
    for (std::size_t i = 0; i < trials; ++i) {
      outcomes[cell].push_back(random.uniform() < rates[cell]);
    }
  }
  return outcomes;
}

TEST(StiffnessClaims, FindsStrongDependence) {
  const auto claims =
      judge_stiffness_claims(draw_outcomes({.9, .95, .95, .6, .6, .6, .2, .2, .2}, 300, 1), 1);
  ASSERT_EQ(claims.size(), 3u);
  EXPECT_EQ(claims[0].verdict, Verdict::kConfirmed);
  EXPECT_NEAR(claims[0].difference, 0.733, 0.06);
  EXPECT_LT(claims[0].interval.low, claims[0].difference);
  EXPECT_GT(claims[0].interval.high, claims[0].difference);
  EXPECT_EQ(claims[1].verdict, Verdict::kConfirmed);
}

TEST(StiffnessClaims, ContradictsWhatIsTheOtherWayRound) {
  const auto claims =
      judge_stiffness_claims(draw_outcomes({.2, .2, .2, .6, .6, .6, .9, .9, .9}, 300, 2), 1);
  for (const StiffnessClaim& claim : claims) EXPECT_EQ(claim.verdict, Verdict::kContradicted);
}

TEST(StiffnessClaims, TenTrialsACellDecideNothingAboutThePapersRates) {
  StiffnessOutcomes paper;
  const std::array<int, 9> successes{6, 8, 9, 7, 8, 4, 5, 6, 7};
  for (std::size_t cell = 0; cell < 9; ++cell) {
    for (int i = 0; i < 10; ++i)
      paper[cell].push_back((i * 7 + int(cell) * 3) % 10 < successes[cell]);
  }
  EXPECT_EQ(judge_stiffness_claims(paper, 3)[0].verdict, Verdict::kUndecided);
}

TEST(StiffnessClaims, AWorldWithoutContrastIsUndecided) {
  const auto claims = judge_stiffness_claims(draw_outcomes({1, 1, 1, 1, 1, 1, 1, 1, 1}, 50, 4), 1);
  for (const StiffnessClaim& claim : claims) {
    EXPECT_EQ(claim.verdict, Verdict::kUndecided);
    EXPECT_EQ(claim.difference, 0.0);
  }
}

TEST(StiffnessClaims, FlatWorldsAreSeldomConfirmed) {
  for (const double share : flat_claim_shares(200, 2.0 / 3.0, 5)) EXPECT_LT(share, 0.05);
}

TEST(StiffnessClaims, FlatSharesAgreeWithFlatWorldsOfTrials) {
  // The same, by drawing trials one by one.
  constexpr int kWorlds = 60;
  int confirmed = 0;
  for (Seed world = 0; world < kWorlds; ++world) {
    std::array<double, 9> flat{};
    flat.fill(2.0 / 3.0);
    const auto claims = judge_stiffness_claims(draw_outcomes(flat, 60, 100 + world), world);
    confirmed += claims[0].verdict == Verdict::kConfirmed ? 1 : 0;
  }
  EXPECT_LE(confirmed, 6);  // of 60 at 1 to 2.5 %
}

TEST(StiffnessClaims, OtherExperimentsHaveNoPlane) {
  EXPECT_TRUE(stiffness_planes(coin_experiment(), {}).empty());
}

std::string plane_yaml(const std::string& values) {
  return "experiment: plane\ntitle: Plane\nkind: coin\nseed: 1\ntrials: 2\nparameters: {rate: "
         "0.5}\n"
         "axes:\n  - {name: K_t_y, key: rate, values: [" +
         values + "]}\n  - {name: K_r_x, key: work_ms, values: [20, 75, 200]}\n";
}

TEST(StiffnessClaims, PlanesOfOtherValuesHaveNoClaims) {
  const auto planes = stiffness_planes(coin_experiment(plane_yaml("0.1, 0.2")), {});
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_EQ(planes[0].translation.size(), 2u);
  EXPECT_EQ(planes[0].cells[1][2], 5u);
  EXPECT_FALSE(planes[0].outcomes);
}

TEST(FlatReference, AFlatWorldPassesAndDoesNotBeatItself) {
  const std::vector<Proportion> paper = {{6, 10}, {8, 10}, {9, 10}, {7, 10}, {8, 10},
                                         {4, 10}, {5, 10}, {6, 10}, {7, 10}};
  const FlatReference large = flat_reference(std::vector<Proportion>(9, {0, 1000}), paper, 1);
  EXPECT_GT(large.compatible_share, 0.99);
  EXPECT_GT(large.gain.low, -2.0);
  EXPECT_LT(large.gain.high, 2.0);
  // Rates estimated from ten trials each are worse than the flat one more often than not.
  const FlatReference small = flat_reference(std::vector<Proportion>(9, {0, 10}), paper, 1);
  EXPECT_LT(small.better_share, 0.3);
  EXPECT_LT(small.gain.low, large.gain.low);
}

}  // namespace
}  // namespace binpick
