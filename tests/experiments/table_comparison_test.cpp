#include "experiments/table_comparison.h"

#include <gtest/gtest.h>

namespace binpick {
namespace {

/// IJRR 2012, Table 1.
const std::vector<Proportion> kPaper = {{6, 10}, {8, 10}, {9, 10}, {7, 10}, {8, 10},
                                        {4, 10}, {5, 10}, {6, 10}, {7, 10}};

std::vector<Proportion> flat_table(double rate) {
  constexpr std::int64_t kMany = 3'000'000;
  return std::vector<Proportion>(kPaper.size(), {std::int64_t(rate * double(kMany)), kMany});
}

TEST(TableComparison, ThePapersCellsCannotBeToldApart) {
  const HomogeneityTest test = test_homogeneity(kPaper);
  EXPECT_NEAR(test.chi_square, 9.0, 1e-9);
  EXPECT_EQ(test.degrees_of_freedom, 8);
  EXPECT_NEAR(test.p, 0.3423, 5e-5);
}

TEST(TableComparison, HomogeneityWithoutContrastSaysNothing) {
  EXPECT_EQ(test_homogeneity({{5, 5}, {9, 9}}).p, 1.0);
  EXPECT_EQ(test_homogeneity({{3, 5}}).degrees_of_freedom, 0);
  EXPECT_EQ(test_homogeneity({{3, 5}, {0, 0}}).p, 1.0);
}

TEST(TableComparison, AFlatModelOfThePooledRatePassesToo) {
  const TableComparison flat = compare_tables(kPaper, kPaper, 1, 1);
  EXPECT_NEAR(flat.highest_gain, 4.69, 0.005);
  const TableComparison pooled = compare_tables(flat_table(2.0 / 3.0), kPaper, 1);
  EXPECT_NEAR(pooled.deviance, 9.38, 0.01);
  EXPECT_NEAR(pooled.gain_over_flat, 0.0, 1e-6);
  EXPECT_NEAR(pooled.bootstrap_p, 0.46, 0.03);
}

TEST(TableComparison, WrongLevelsFail) {
  const TableComparison half = compare_tables(flat_table(0.5), kPaper, 1);
  EXPECT_NEAR(half.deviance, 19.6, 0.05);
  EXPECT_LT(half.bootstrap_p, 0.05);
  const TableComparison high = compare_tables(flat_table(0.9), kPaper, 1);
  EXPECT_NEAR(high.deviance, 45.6, 0.05);
  EXPECT_LT(high.bootstrap_p, 0.001);
  EXPECT_LT(high.gain_over_flat, 0.0);
}

TEST(TableComparison, TheBootstrapRejectsFiveInAHundredTrueTables) {
  // Tables drawn from the very world that ours is estimated from.
  int rejected = 0;
  constexpr int kTables = 400;
  for (std::uint64_t table = 0; table < kTables; ++table) {
    Random random(derive_seed(7, table));
    std::vector<Proportion> ours;
    std::vector<Proportion> paper;
    for (int cell = 0; cell < 9; ++cell) {
      const double rate = random.uniform(0.3, 0.9);
      Proportion large{0, 200};
      Proportion small{0, 10};
      for (int i = 0; i < 200; ++i) large.successes += random.uniform() < rate ? 1 : 0;
      for (int i = 0; i < 10; ++i) small.successes += random.uniform() < rate ? 1 : 0;
      ours.push_back(large);
      paper.push_back(small);
    }
    if (compare_tables(ours, paper, derive_seed(8, table), 200).bootstrap_p <= 0.05) ++rejected;
  }
  // 95 % interval of 400 draws at 5 %, widened by the interplay of the two estimates.
  EXPECT_GE(rejected, 6);
  EXPECT_LE(rejected, 36);
}

TEST(TableComparison, DependsOnNothingButItsArguments) {
  EXPECT_EQ(compare_tables(flat_table(0.6), kPaper, 5, 500).bootstrap_p,
            compare_tables(flat_table(0.6), kPaper, 5, 500).bootstrap_p);
}

}  // namespace
}  // namespace binpick
