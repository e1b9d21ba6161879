#include "recognition/acceptance_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "models/random.h"
#include "recognition/logistic_fit.h"

namespace binpick {
namespace {

using testing::LabelledFeatures;

/// Rows whose log odds are 1 + 2 x - |y| for two features x, y; the others are noise.
std::vector<LabelledFeatures> rows(int count, Seed seed) {
  Random random(seed);
  std::vector<LabelledFeatures> all;
  for (int i = 0; i < count; ++i) {
    LabelledFeatures row;
    for (double& value : row.features) value = random.normal();
    const double log_odds = 1.0 + 2.0 * row.features[2] - 2.0 * std::abs(row.features[4]);
    row.is_right = random.uniform() < probability(log_odds);
    all.push_back(row);
  }
  return all;
}

TEST(AcceptanceModel, FitRecoversKnownLogOdds) {
  const AcceptanceModel model = testing::fit_acceptance(rows(6000, 1), 3.0);
  double squares = 0.0;
  const std::vector<LabelledFeatures> fresh = rows(500, 2);
  for (const LabelledFeatures& row : fresh) {
    const double truth = 1.0 + 2.0 * row.features[2] - 2.0 * std::abs(row.features[4]);
    squares += std::pow(model.log_odds(row.features) - truth, 2);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(fresh.size())), 0.5);
}

TEST(AcceptanceModel, RecalibrationUndoesAScale) {
  const std::vector<LabelledFeatures> data = rows(6000, 3);
  const AcceptanceModel model = testing::fit_acceptance(data, 3.0);
  AcceptanceModel overconfident = model;
  overconfident.bias *= 3.0;
  for (auto& term : overconfident.terms) {
    term.slope *= 3.0;
    for (double& bend : term.bends) bend *= 3.0;
  }
  for (auto& product : overconfident.products) product.weight *= 3.0;
  testing::recalibrate(overconfident, data);
  // The ridge makes the fit a little too modest for its own rows.
  for (std::size_t i = 0; i < 100; ++i) {
    const double fitted = model.log_odds(data[i].features);
    EXPECT_NEAR(overconfident.log_odds(data[i].features), fitted, 0.05 + 0.1 * std::abs(fitted));
  }
}

TEST(AcceptanceModel, NothingIsExtrapolated) {
  const AcceptanceModel& model = calibrated_acceptance();
  FeatureVector at_limit{};
  for (std::size_t i = 0; i < kFeatures; ++i) at_limit[i] = model.terms[i].high;
  FeatureVector beyond = at_limit;
  for (double& value : beyond) value += 10.0;
  EXPECT_EQ(model.log_odds(beyond), model.log_odds(at_limit));
}

TEST(AcceptanceModel, ContradictionsLowerTheOdds) {
  HypothesisEvidence good;
  good.rendered = 2000;
  good.matched = 1900;
  good.edges = 100;
  good.edges_matched = 80;
  good.edge_spread = 0.7f;
  good.residual_rms = 0.3f;
  good.normal_error = 0.01f;
  good.second_face = 0.3f;
  good.expected = 2000.0f;
  const auto odds = [](const HypothesisEvidence& e) {
    return calibrated_acceptance().log_odds(acceptance_features(e, 0.0));
  };
  EXPECT_GT(odds(good), 0.0);
  HypothesisEvidence near = good;
  near.near_occluded = 600;
  near.matched -= 600;
  EXPECT_LT(odds(near), odds(good) - 1.0);
  HypothesisEvidence through = good;
  through.seen_through = 600;
  through.matched -= 600;
  EXPECT_LT(odds(through), odds(good) - 1.0);
  HypothesisEvidence without_steps = good;
  without_steps.edges_matched = 0;
  EXPECT_LT(odds(without_steps), odds(good) - 1.0);
}

}  // namespace
}  // namespace binpick
