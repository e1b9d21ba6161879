#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "recognition/hypothesis.h"
#include "recognition/hypothesis_clusters.h"
#include "recognition/model_library.h"
#include "recognition/observed_scene.h"
#include "recognition/render_verification.h"

namespace binpick {

/// A hypothesis that stood the comparison with the scene.
struct Candidate {
  int model = 0;
  Eigen::Isometry3f T_camera_model = Eigen::Isometry3f::Identity();
  RenderComparison comparison;
};

/// From many hypotheses to few detections, for the default setting: clusters what was generated,
/// aligns the best of each cluster, verifies it by rendering, and picks a consistent set.
class CandidatePool {
 public:
  CandidatePool(const ModelLibrary& library, const ObservedScene& scene, double visibility,
                int jobs);

  /// Takes the hypotheses of one sampling round; at most `most_per_model` clusters are looked at.
  /// `slide` also searches along the directions that a flat face leaves open: for hypotheses from
  /// coplanar pairs.
  void add(std::vector<Hypothesis> hypotheses, int most_per_model, bool slide);

  /// Moves candidates along directions that their points leave open to where the silhouette fits
  /// best.
  [[nodiscard]] std::vector<Candidate> slide(const std::vector<const Candidate*>& selected) const;

  /// The best set of candidates that do not claim the same points of S*, best first.
  [[nodiscard]] std::vector<const Candidate*> select() const;

  [[nodiscard]] int verified() const noexcept { return verified_; }
  [[nodiscard]] int accepted() const noexcept { return static_cast<int>(candidates_.size()); }

 private:
  void verify(std::vector<Hypothesis> hypotheses, bool slide);
  void slide_to_silhouette(DepthRasterizer& rasterizer, Candidate& candidate) const;

  const ModelLibrary& library_;
  const ObservedScene& scene_;
  double facing_visibility_;
  int jobs_;
  int verified_ = 0;
  std::vector<ModelTolerances> tolerances_;
  std::vector<Hypothesis> tried_;  // aligned poses that were compared before
  std::vector<Candidate> candidates_;
};

}  // namespace binpick
