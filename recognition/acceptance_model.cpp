#include "recognition/acceptance_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace binpick {

FeatureVector acceptance_features(const HypothesisEvidence& evidence, double dilation) {
  const double decided =
      std::max(evidence.matched + evidence.bad_normal + evidence.seen_through +
                   evidence.seen_through_rim + evidence.near_occluded + evidence.claimed,
               1);
  const double rendered = std::max(evidence.rendered, 1);
  const double edges = std::max(evidence.edges, 1);
  const auto root = [](double count, double of) { return std::sqrt(count / of); };
  FeatureVector features{};
  const auto set = [&](Feature feature, double value) {
    features[static_cast<std::size_t>(feature)] = value;
  };
  set(Feature::kEvidence, std::log(evidence.matched + 1.0));
  set(Feature::kTypicalShare,
      std::log((evidence.matched + 1.0) / (static_cast<double>(evidence.expected) + 1.0)));
  set(Feature::kMatchedShare, evidence.matched / rendered);
  set(Feature::kBadNormal, root(evidence.bad_normal, decided));
  set(Feature::kSeenThrough, root(evidence.seen_through, decided));
  set(Feature::kSeenThroughRim, root(evidence.seen_through_rim, decided));
  set(Feature::kNearOccluded, root(evidence.near_occluded, decided));
  set(Feature::kClaimed, root(evidence.claimed, decided));
  set(Feature::kContinued, root(evidence.edges_continued, edges));
  set(Feature::kEdgesMatched, evidence.edges_matched / edges);
  set(Feature::kEdgesOpen, root(evidence.edges_open, edges));
  set(Feature::kEdgesAgree,
      (evidence.edges_matched + evidence.edges_open) / std::max<double>(evidence.edges_seen, 1.0));
  set(Feature::kEdgesMissed, root(evidence.edges_missed, edges));
  if (evidence.edges_matched > 0) {
    set(Feature::kEdgeOffset, std::abs(static_cast<double>(evidence.edge_offset) - dilation));
    set(Feature::kEdgeSpread, static_cast<double>(evidence.edge_spread));
  }
  set(Feature::kResidualBias, std::abs(static_cast<double>(evidence.residual_mean)));
  set(Feature::kResidualSpread, static_cast<double>(evidence.residual_rms));
  set(Feature::kNormalError, std::sqrt(static_cast<double>(evidence.normal_error)));
  set(Feature::kSecondFace, std::sqrt(static_cast<double>(evidence.second_face)));
  set(Feature::kFixed, std::log(static_cast<double>(evidence.least_information) + 1.0));
  set(Feature::kResolution, std::log(static_cast<double>(evidence.expected) + 1.0));
  set(Feature::kUnseen, (evidence.missing + evidence.on_support) / rendered);
  return features;
}

double direction_of(Feature feature) {
  switch (feature) {
    case Feature::kEvidence:
    case Feature::kTypicalShare:
    case Feature::kMatchedShare:
    case Feature::kEdgesMatched:
    case Feature::kEdgesOpen:
    case Feature::kEdgesAgree:
    case Feature::kSecondFace:
    case Feature::kFixed:
      return 1.0;
    default:
      return -1.0;
  }
}

double AcceptanceModel::standardised(Feature feature, double value) const {
  const Term& term = terms[static_cast<std::size_t>(feature)];
  return (std::clamp(value, term.low, term.high) - term.centre) / term.scale;
}

double AcceptanceModel::log_odds(const FeatureVector& features) const {
  double sum = bias;
  for (std::size_t i = 0; i < kFeatures; ++i) {
    const Term& term = terms[i];
    const double x = standardised(static_cast<Feature>(i), features[i]);
    sum += term.slope * x;
    for (std::size_t k = 0; k < kKnots; ++k) {
      sum += term.bends[k] * std::max(x - term.knots[k], 0.0);
    }
  }
  return sum;
}

double AcceptanceModel::detection_probability(double log_odds, double margin,
                                              double displacement) const {
  return probability(in_set.bias + in_set.log_odds * log_odds + in_set.margin * margin) *
         probability_in_place(displacement);
}

double probability(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

double probability_in_place(double displacement) {
  return std::erf(kRightPose / (std::numbers::sqrt2 * displacement));
}

}  // namespace binpick
