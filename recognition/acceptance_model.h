#pragma once

#include <array>
#include <cstddef>

#include "recognition/hypothesis_evidence.h"

namespace binpick {

/// What the decision about a hypothesis is based on, in an order that the calibration relies on.
/// Shares are of the pixels that say something, or of the silhouette's samples; those near zero
/// enter by their square root, which evens out their spread.
enum class Feature : std::size_t {
  kEvidence,        ///< log of the matched pixels
  kTypicalShare,    ///< log of the matched pixels relative to a typical unoccluded view
  kMatchedShare,    ///< of all rendered pixels
  kBadNormal,       ///< root of the share
  kSeenThrough,     ///< root of the share, inside
  kSeenThroughRim,  ///< root of the share, along the silhouette
  kNearOccluded,    ///< root of the share
  kClaimed,         ///< root of the share that another object explains
  kContinued,       ///< root of the silhouette's share beyond which the surface goes on
  kEdgesMatched,    ///< share of the silhouette at which the scene steps back
  kEdgesOpen,       ///< root of the share at which the surface ends at what was not measured
  kEdgesAgree,      ///< share of the silhouette in view at which either is so
  kEdgesMissed,     ///< root of the share at which the scene is behind the model far inside
  kEdgeOffset,      ///< how far the steps lie from where the sensor's dilation puts them, pixels
  kEdgeSpread,      ///< standard deviation of their places, pixels
  kResidualBias,    ///< size of the mean residual, model tolerances
  kResidualSpread,  ///< root mean square residual, limits of agreement
  kNormalError,     ///< root of the mean of 1 - cos between the normals
  kSecondFace,      ///< root of the middle eigenvalue of the scatter of the matched normals
  kUnseen,          ///< share of rendered pixels without measurement or on a support plane
  kFixed,           ///< log of the least information about the place, pixels
  kResolution,      ///< log of the pixels of a typical unoccluded view: few show what is right ill
  kCount
};
constexpr std::size_t kFeatures = static_cast<std::size_t>(Feature::kCount);
using FeatureVector = std::array<double, kFeatures>;

/// `dilation` is the sensor's, in pixels: what edge offsets are compared with.
[[nodiscard]] FeatureVector acceptance_features(const HypothesisEvidence& evidence,
                                                double dilation);

/// Whether more of a feature speaks for a hypothesis, 1, or against it, -1.
[[nodiscard]] double direction_of(Feature feature);

/// log p(right | features) - log p(wrong | features): a sum of piecewise linear functions, one of
/// each feature. Features are clamped to the range seen in calibration, so that nothing is
/// extrapolated. The calibration sees to it that the odds never fall when a feature gets better
/// (direction_of()): a fit is not rejected for being better than those of the calibration.
struct AcceptanceModel {
  static constexpr std::size_t kKnots = 3;
  struct Term {
    double low = 0.0, high = 1.0;      ///< the range that calibration saw
    double centre = 0.0, scale = 1.0;  ///< of the standardised feature
    double slope = 0.0;
    std::array<double, kKnots> knots{};  ///< in the standardised feature
    std::array<double, kKnots> bends{};  ///< change of slope at each knot
  };
  double bias = 0.0;
  std::array<Term, kFeatures> terms{};
  /// From the log odds of a hypothesis to those of a member of the chosen set: another pose of the
  /// model, or another model, that explains nearly as much says that this one may be wrong.
  struct InSet {
    double bias = 0.0;
    double log_odds = 1.0;
    double margin = 0.0;
  };
  InSet in_set{};
  double least_probability = 0.5;  ///< of a detection that is reported

  [[nodiscard]] double standardised(Feature feature, double value) const;
  [[nodiscard]] double log_odds(const FeatureVector& features) const;
  /// That a member of the chosen set is right: that the object is there, and that it is not
  /// elsewhere than its pose says. `log_odds` are its own beside the others, `margin` is what the
  /// best set without it lacks, `displacement` that of its most_uncertain_motion() in diameters.
  [[nodiscard]] double detection_probability(double log_odds, double margin,
                                             double displacement) const;
};

/// A pose is right if no surface point is farther off, diameters, symmetries applied (MSSD).
constexpr double kRightPose = 0.1;

/// 1 / (1 + exp(-log_odds)).
[[nodiscard]] double probability(double log_odds);

/// That a pose whose most_uncertain_motion() displaces it that many diameters is right, if the
/// object is there.
[[nodiscard]] double probability_in_place(double displacement);

/// The model that tests/recognition/acceptance_calibration_main.cpp made from generated scenes
/// (acceptance_weights.cpp).
[[nodiscard]] const AcceptanceModel& calibrated_acceptance();

}  // namespace binpick
