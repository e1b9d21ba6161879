#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "recognition/hypothesis.h"
#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// The tolerances that follow from a model's size and the scene's noise.
struct ModelTolerances {
  float coarse = 0.0f;  ///< for poses straight from a point pair, m
  float fine = 0.0f;    ///< for aligned poses, m
};
[[nodiscard]] ModelTolerances tolerances_for(const RecognitionModel& model, float noise);

/// Keeps the best hypothesis of every cluster of poses closer than `share` of the diameter
/// (symmetry-aware), none close to one of `known`. Best first per model. If there are more than
/// `most` of a model, the best at every place in the scene is kept before the second best anywhere:
/// a large thing that is no model fits many poses better than a model fits what is mostly hidden.
[[nodiscard]] std::vector<Hypothesis> keep_cluster_heads(
    std::vector<Hypothesis> hypotheses, const std::vector<RecognitionModel>& models, float share,
    int most, int jobs, const std::vector<Hypothesis>& known = {});

/// How the hypotheses of one sampling round become few aligned ones.
struct ClusteringOptions {
  int most_per_model = 30;         ///< clusters that are looked at
  double facing_visibility = 0.0;  ///< least share of matched points that face the sensor
  int jobs = 1;
};

/// The best hypothesis of every cluster, aligned with the scene (coarse, then fine): those that
/// still stand, none close to another or to one of `known`. Best first per model.
[[nodiscard]] std::vector<Hypothesis> cluster_and_align(std::vector<Hypothesis> hypotheses,
                                                        const std::vector<RecognitionModel>& models,
                                                        const ObservedScene& scene,
                                                        const ClusteringOptions& options,
                                                        const std::vector<Hypothesis>& known);

}  // namespace binpick
