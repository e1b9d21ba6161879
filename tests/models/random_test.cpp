#include "models/random.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace binpick {
namespace {

constexpr int kDraws = 200000;

TEST(Random, DrawsMatchKnownAnswers) {
  // Written down once; a change here moves every pile, noise and hypothesis of every experiment.
  Random random(42);
  std::vector<std::uint64_t> first{random.bits(), random.bits(), random.bits()};
  EXPECT_EQ(first, (std::vector<std::uint64_t>{0xF5F305129C198E00u, 0x071DA5FAFB53570Au,
                                               0x449E6A7F59C16ECBu}));
  EXPECT_EQ(derive_seed(42, "pile"), 0xA26E5BEA2C4517B2u);
  EXPECT_EQ(derive_seed(42, std::uint64_t{7}), 0xDD6452BC94F5081Cu);
}

TEST(Random, AStreamCanBeEnteredAnywhere) {
  Random from_start(7);
  for (int i = 0; i < 100; ++i) static_cast<void>(from_start.bits());
  Random entered(7, 100);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(entered.bits(), from_start.bits());
}

TEST(Random, UniformHasTheMomentsOfItsDistribution) {
  Random random(1);
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    sum_of_squares += u * u;
  }
  // Five standard deviations of the estimates.
  EXPECT_NEAR(sum / kDraws, 0.5, 5 * 0.2887 / std::sqrt(kDraws));
  EXPECT_NEAR(sum_of_squares / kDraws, 1.0 / 3.0, 5 * 0.2981 / std::sqrt(kDraws));
}

TEST(Random, NormalHasTheMomentsOfItsDistribution) {
  Random random(2);
  double moments[4] = {};
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    for (int k = 0; k < 4; ++k) moments[k] += std::pow(x, k + 1) / kDraws;
  }
  const double root = std::sqrt(kDraws);
  EXPECT_NEAR(moments[0], 0.0, 5 / root);
  EXPECT_NEAR(moments[1], 1.0, 5 * std::sqrt(2.0) / root);
  EXPECT_NEAR(moments[2], 0.0, 5 * std::sqrt(15.0) / root);
  EXPECT_NEAR(moments[3], 3.0, 5 * std::sqrt(96.0) / root);
}

TEST(Random, IndexReachesEveryValueEquallyOften) {
  Random random(3);
  std::vector<int> counts(7, 0);
  for (int i = 0; i < kDraws; ++i) ++counts.at(random.index(7));
  double chi_squared = 0.0;
  const double expected = kDraws / 7.0;
  for (const int count : counts) chi_squared += std::pow(count - expected, 2) / expected;
  EXPECT_LT(chi_squared, 33.1);  // 6 degrees of freedom, p = 1e-5
}

TEST(Random, UnitVectorsAreUnitAndIsotropic) {
  Random random(4);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  const int draws = kDraws / 4;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Vector3d v = random.unit_vector();
    ASSERT_NEAR(v.norm(), 1.0, 1e-12);
    mean += v / draws;
    square += v * v.transpose() / draws;
  }
  EXPECT_LT(mean.norm(), 0.015);
  EXPECT_LT((square - Eigen::Matrix3d::Identity() / 3.0).norm(), 0.01);
}

TEST(Random, RotationsAreUniformOverSo3) {
  Random random(5);
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  double mean_angle = 0.0;
  const int draws = kDraws / 4;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Quaterniond q = random.rotation();
    ASSERT_NEAR(q.norm(), 1.0, 1e-12);
    mean += q.toRotationMatrix() / draws;
    mean_angle += q.angularDistance(Eigen::Quaterniond::Identity()) / draws;
  }
  EXPECT_LT(mean.norm(), 0.03);
  // The angle of a random rotation has the mean pi/2 + 2/pi.
  EXPECT_NEAR(mean_angle, M_PI / 2 + 2 / M_PI, 0.02);
}

TEST(DeriveSeed, PurposesAndIndicesGiveDistinctUncorrelatedSeeds) {
  std::set<Seed> seeds;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    seeds.insert(derive_seed(99, i));
    seeds.insert(derive_seed(99, "purpose " + std::to_string(i)));
    seeds.insert(derive_seed(i, "pile"));
  }
  EXPECT_EQ(seeds.size(), 15000u);

  // First draws of neighbouring seeds, as a sweep uses them.
  double correlation = 0.0;
  const int pairs = 20000;
  for (int i = 0; i < pairs; ++i) {
    Random a(derive_seed(1, static_cast<std::uint64_t>(i)));
    Random b(derive_seed(1, static_cast<std::uint64_t>(i + 1)));
    correlation += 12.0 * (a.uniform() - 0.5) * (b.uniform() - 0.5) / pairs;
  }
  EXPECT_NEAR(correlation, 0.0, 5 / std::sqrt(pairs));
}

}  // namespace
}  // namespace binpick
