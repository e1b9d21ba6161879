#include "recognition/hypothesis_clusters.h"

#include <algorithm>
#include <optional>

#include "recognition/acceptance_function.h"
#include "recognition/parallel_for.h"
#include "recognition/projective_alignment.h"

namespace binpick {
namespace {

constexpr float kClusterShare = 0.12f;    // of the diameter, before alignment
constexpr float kDuplicateShare = 0.04f;  // of the diameter, after alignment
constexpr float kMostOccluding = 0.15f;   // of the points that face the sensor

/// The poses of the model's bounding box corners decide how far two poses are apart.
class PoseDistance {
 public:
  explicit PoseDistance(const RecognitionModel& model) {
    for (const Eigen::Isometry3d& symmetry : model.symmetries) {
      symmetries_.push_back(symmetry.cast<float>());
    }
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : model.hull) box.extend(p);
    centre_ = box.center();
    for (int corner = 0; corner < 8; ++corner) {
      corners_.push_back(box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)));
    }
  }

  [[nodiscard]] bool closer(const Eigen::Isometry3f& a, const Eigen::Isometry3f& b,
                            float limit) const {
    return std::any_of(symmetries_.begin(), symmetries_.end(), [&](const auto& symmetry) {
      const Eigen::Isometry3f equivalent = b * symmetry;
      if ((a * centre_ - equivalent * centre_).norm() > limit) return false;
      return std::all_of(corners_.begin(), corners_.end(), [&](const Eigen::Vector3f& p) {
        return (a * p - equivalent * p).squaredNorm() < limit * limit;
      });
    });
  }

 private:
  std::vector<Eigen::Isometry3f> symmetries_;
  Eigen::Vector3f centre_;
  std::vector<Eigen::Vector3f> corners_;
};

/// Aligns every hypothesis and keeps those that stand an exact test with the fine tolerance.
std::vector<Hypothesis> align(std::vector<Hypothesis> hypotheses,
                              const std::vector<RecognitionModel>& models,
                              const ObservedScene& scene, const ClusteringOptions& options) {
  std::vector<char> stands(hypotheses.size(), 0);
  parallel_chunks(
      static_cast<int>(hypotheses.size()), 4, options.jobs, [&](int, int begin, int end) {
        for (int i = begin; i < end; ++i) {
          Hypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
          const auto index = static_cast<std::size_t>(hypothesis.model);
          const RecognitionModel& model = models[index];
          const ModelTolerances tolerance = tolerances_for(model, scene.noise());
          Eigen::Isometry3f T = hypothesis.T_camera_model;
          T = align_projectively(scene, model, T, {1.5f * tolerance.coarse, 128, 4});
          T = align_projectively(scene, model, T, {1.5f * tolerance.fine, 512, 6});
          const FacingCounts counts =
              count_facing(scene, model, T, tolerance.fine, 0, model.test_points.size());
          hypothesis.T_camera_model = T;
          hypothesis.score = counts.score();
          const auto facing = static_cast<float>(counts.facing);
          stands[static_cast<std::size_t>(i)] =
              static_cast<float>(counts.matched) >
                  static_cast<float>(options.facing_visibility) * facing &&
              static_cast<float>(counts.occluding) < kMostOccluding * facing &&
              !sinks_into_support(scene, model, T, 2.0f * tolerance.fine + 0.02f * model.diameter);
        }
      });
  std::vector<Hypothesis> standing;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    if (stands[i] != 0) standing.push_back(hypotheses[i]);
  }
  return standing;
}

}  // namespace

ModelTolerances tolerances_for(const RecognitionModel& model, float noise) {
  // The fine band has a floor besides the noise: the sensor's slow distortion and the model's own
  // errors do not show in small patches.
  return {0.035f * model.diameter, std::max(3.2f * noise, 0.01f * model.diameter)};
}

std::vector<Hypothesis> keep_cluster_heads(std::vector<Hypothesis> hypotheses,
                                           const std::vector<RecognitionModel>& models, float share,
                                           int most, const std::vector<Hypothesis>& known) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(), [](const auto& a, const auto& b) {
    return a.model != b.model ? a.model < b.model : a.score > b.score;
  });
  std::vector<Hypothesis> heads;
  int model = -1;
  std::size_t first_of_model = 0;
  std::optional<PoseDistance> distance;
  for (const Hypothesis& hypothesis : hypotheses) {
    const RecognitionModel& shape = models[static_cast<std::size_t>(hypothesis.model)];
    if (hypothesis.model != model) {
      model = hypothesis.model;
      first_of_model = heads.size();
      distance.emplace(shape);
    }
    if (heads.size() - first_of_model >= static_cast<std::size_t>(most)) continue;
    const auto is_close = [&](const Hypothesis& other) {
      return other.model == model && distance->closer(hypothesis.T_camera_model,
                                                      other.T_camera_model, share * shape.diameter);
    };
    const auto begin = heads.begin() + static_cast<std::ptrdiff_t>(first_of_model);
    if (std::any_of(begin, heads.end(), is_close)) continue;
    if (std::any_of(known.begin(), known.end(), is_close)) continue;
    heads.push_back(hypothesis);
  }
  return heads;
}

std::vector<Hypothesis> cluster_and_align(std::vector<Hypothesis> hypotheses,
                                          const std::vector<RecognitionModel>& models,
                                          const ObservedScene& scene,
                                          const ClusteringOptions& options,
                                          const std::vector<Hypothesis>& known) {
  const std::vector<Hypothesis> heads =
      keep_cluster_heads(std::move(hypotheses), models, kClusterShare, options.most_per_model);
  return keep_cluster_heads(align(heads, models, scene, options), models, kDuplicateShare,
                            options.most_per_model, known);
}

}  // namespace binpick
