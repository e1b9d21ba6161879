#include "recognition/acceptance_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "models/random.h"
#include "recognition/logistic_fit.h"

namespace binpick {
namespace {

using testing::LabelledFeatures;

/// Two features decide: the larger the matched share the better, though less so when it is large,
/// and the fewer pixels are seen through the better; the others are noise.
double true_log_odds(const FeatureVector& features) {
  const double matched = features[static_cast<std::size_t>(Feature::kMatchedShare)];
  const double through = features[static_cast<std::size_t>(Feature::kSeenThrough)];
  return 1.0 + 2.0 * std::min(matched, 0.5) - 2.0 * std::max(through, 0.0);
}

std::vector<LabelledFeatures> rows(int count, Seed seed) {
  Random random(seed);
  std::vector<LabelledFeatures> all;
  for (int i = 0; i < count; ++i) {
    LabelledFeatures row;
    for (double& value : row.features) value = random.normal();
    row.is_right = random.uniform() < probability(true_log_odds(row.features));
    all.push_back(row);
  }
  return all;
}

/// The least that the log odds gain when one feature gets better, over many random places in the
/// features' ranges.
double least_gain(const AcceptanceModel& model) {
  constexpr int kPlaces = 20000;
  Random random(5);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kPlaces; ++i) {
    FeatureVector features{};
    for (std::size_t f = 0; f < kFeatures; ++f) {
      features[f] = random.uniform(model.terms[f].low, model.terms[f].high);
    }
    FeatureVector better = features;
    const auto f = static_cast<std::size_t>(random.index(kFeatures));
    const bool rises = direction_of(static_cast<Feature>(f)) > 0.0;
    const double best = rises ? model.terms[f].high : model.terms[f].low;
    better[f] += random.uniform() * (best - better[f]);
    least = std::min(least, model.log_odds(better) - model.log_odds(features));
  }
  return least;
}

TEST(AcceptanceModel, FitRecoversKnownLogOdds) {
  const AcceptanceModel model = testing::fit_acceptance(rows(6000, 1), 3.0);
  double squares = 0.0;
  const std::vector<LabelledFeatures> fresh = rows(500, 2);
  for (const LabelledFeatures& row : fresh) {
    squares += std::pow(model.log_odds(row.features) - true_log_odds(row.features), 2);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(fresh.size())), 0.5);
}

TEST(AcceptanceModel, WhatLooksBetterIsNeverLessCredible) {
  EXPECT_GE(least_gain(calibrated_acceptance()), -1e-3);  // weights are written with six digits
}

TEST(AcceptanceModel, FitNeverFallsEvenWhereTheRowsDo) {
  Random random(4);
  std::vector<LabelledFeatures> data = rows(3000, 4);
  for (LabelledFeatures& row : data) {
    const double bad_normal = row.features[static_cast<std::size_t>(Feature::kBadNormal)];
    row.is_right = random.uniform() < probability(1.0 - 2.0 * std::abs(bad_normal));
  }
  const AcceptanceModel model = testing::fit_acceptance(data, 1.0);
  EXPECT_GE(least_gain(model), -1e-9);
}

TEST(AcceptanceModel, RecalibrationUndoesAScale) {
  const std::vector<LabelledFeatures> data = rows(6000, 3);
  const AcceptanceModel model = testing::fit_acceptance(data, 3.0);
  AcceptanceModel recalibrated = model;
  testing::Recalibration{3.0, 1.0}.apply(recalibrated);
  std::vector<testing::JudgedRow> judged;
  for (const LabelledFeatures& row : data) {
    judged.push_back({recalibrated.log_odds(row.features), 0.0, row.is_right});
  }
  testing::recalibration_of(judged).apply(recalibrated);
  // The ridge makes the fit a little too modest for its own rows.
  for (std::size_t i = 0; i < 100; ++i) {
    const double fitted = model.log_odds(data[i].features);
    EXPECT_NEAR(recalibrated.log_odds(data[i].features), fitted, 0.05 + 0.1 * std::abs(fitted));
  }
}

TEST(AcceptanceModel, FitFindsWhatTheSetSaysAboutItsMembers) {
  const AcceptanceModel::InSet truth{-2.0, 0.8, 1.2};
  AcceptanceModel model;
  model.in_set = truth;
  Random random(5);
  std::vector<testing::JudgedRow> judged;
  for (int i = 0; i < 20000; ++i) {
    testing::JudgedRow row;
    row.log_odds = random.uniform(-3.0, 6.0);
    row.margin = random.uniform(0.0, 4.0);
    row.is_there = random.uniform() < model.detection_probability(row.log_odds, row.margin, 0.0);
    judged.push_back(row);
  }
  const AcceptanceModel::InSet fitted = testing::fit_in_set(judged);
  EXPECT_NEAR(fitted.log_odds, truth.log_odds, 0.05);
  EXPECT_NEAR(fitted.margin, truth.margin, 0.07);
  EXPECT_NEAR(fitted.bias, truth.bias, 0.1);
}

TEST(AcceptanceModel, WhatMayLieElsewhereIsDoubtful) {
  EXPECT_EQ(probability_in_place(0.0), 1.0);
  // The normal distribution within one, two and three standard deviations.
  EXPECT_NEAR(probability_in_place(kRightPose), 0.6827, 1e-4);
  EXPECT_NEAR(probability_in_place(kRightPose / 2.0), 0.9545, 1e-4);
  EXPECT_NEAR(probability_in_place(kRightPose / 3.0), 0.9973, 1e-4);
  const AcceptanceModel& model = calibrated_acceptance();
  EXPECT_NEAR(model.detection_probability(5.0, 3.0, kRightPose),
              0.6827 * model.detection_probability(5.0, 3.0, 0.0), 1e-4);
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
  good.edges = good.edges_seen = 100;
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
  HypothesisEvidence before_nothing = without_steps;
  before_nothing.edges_open = 80;
  EXPECT_GT(odds(before_nothing), odds(without_steps) + 1.0)
      << "no measurement is no contradiction";
}

}  // namespace
}  // namespace binpick
