#include "recognition/candidate_pool.h"

#include <algorithm>
#include <array>
#include <optional>

#include "recognition/acceptance_function.h"
#include "recognition/conflict_graph.h"
#include "recognition/parallel_for.h"
#include "recognition/pose_refinement.h"

namespace binpick {
namespace {

constexpr float kClusterShare = 0.12f;     // of the diameter, before alignment
constexpr float kDuplicateShare = 0.04f;   // of the diameter, after alignment
constexpr float kMostOccluding = 0.15f;    // of the points that face the sensor
constexpr double kHopelessBadness = 0.4;   // no sliding helps
constexpr double kToleratedOverlap = 0.2;  // of the smaller explained set

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

CandidatePool::CandidatePool(const ModelLibrary& library, const ObservedScene& scene,
                             double visibility, int jobs)
    : library_(library), scene_(scene), facing_visibility_(1.2 * visibility), jobs_(jobs) {
  for (const RecognitionModel& model : library.models()) {
    tolerances_.push_back(tolerances_for(model, scene.noise()));
  }
}

void CandidatePool::add(std::vector<Hypothesis> hypotheses, int most_per_model, bool slide) {
  const std::vector<Hypothesis> heads =
      keep_cluster_heads(std::move(hypotheses), library_.models(), kClusterShare, most_per_model);
  const std::vector<Hypothesis> fresh =
      keep_cluster_heads(align(heads), library_.models(), kDuplicateShare, most_per_model, tried_);
  tried_.insert(tried_.end(), fresh.begin(), fresh.end());
  verify(fresh, slide);
}

std::vector<Hypothesis> CandidatePool::align(std::vector<Hypothesis> hypotheses) const {
  std::vector<char> stands(hypotheses.size(), 0);
  parallel_chunks(static_cast<int>(hypotheses.size()), 4, jobs_, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Hypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
      const auto index = static_cast<std::size_t>(hypothesis.model);
      const RecognitionModel& model = library_.models()[index];
      const ModelTolerances& tolerance = tolerances_[index];
      Eigen::Isometry3f T = hypothesis.T_camera_model;
      T = align_projectively(scene_, model, T, {1.5f * tolerance.coarse, 128, 4});
      T = align_projectively(scene_, model, T, {1.5f * tolerance.fine, 512, 6});
      const FacingCounts counts =
          count_facing(scene_, model, T, tolerance.fine, 0, model.test_points.size());
      hypothesis.T_camera_model = T;
      hypothesis.score = counts.score();
      const auto facing = static_cast<float>(counts.facing);
      stands[static_cast<std::size_t>(i)] =
          static_cast<float>(counts.matched) > static_cast<float>(facing_visibility_) * facing &&
          static_cast<float>(counts.occluding) < kMostOccluding * facing &&
          !sinks_into_support(scene_, model, T, 2.0f * tolerance.fine + 0.02f * model.diameter);
    }
  });
  std::vector<Hypothesis> standing;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    if (stands[i] != 0) standing.push_back(hypotheses[i]);
  }
  return standing;
}

void CandidatePool::slide_to_silhouette(DepthRasterizer& rasterizer, Candidate& candidate) const {
  constexpr std::array<float, 4> kSteps = {0.04f, 0.02f, 0.01f, 0.005f};  // of the diameter
  const auto index = static_cast<std::size_t>(candidate.model);
  const RecognitionModel& model = library_.models()[index];
  const float epsilon = tolerances_[index].fine;
  const OpenDirections open =
      open_directions(scene_, model, candidate.T_camera_model, 1.5f * epsilon);
  for (const float step : kSteps) {
    for (int i = 0; i < open.count; ++i) {
      for (const float sign : {-1.0f, 1.0f}) {
        const Eigen::Isometry3f T = move_along(model, candidate.T_camera_model, open.motions.col(i),
                                               sign * step * model.diameter);
        RenderComparison comparison = compare_by_rendering(rasterizer, scene_, model, T, epsilon);
        if (comparison.quality() <= candidate.comparison.quality()) continue;
        candidate.comparison = std::move(comparison);
        candidate.T_camera_model = T;
      }
    }
  }
}

std::vector<Candidate> CandidatePool::slide(const std::vector<const Candidate*>& selected) const {
  std::vector<Candidate> moved;
  for (const Candidate* candidate : selected) moved.push_back(*candidate);
  parallel_for(static_cast<int>(moved.size()), jobs_, [&](int i) {
    DepthRasterizer rasterizer;
    slide_to_silhouette(rasterizer, moved[static_cast<std::size_t>(i)]);
  });
  return moved;
}

void CandidatePool::verify(std::vector<Hypothesis> hypotheses, bool slide) {
  std::vector<Candidate> compared(hypotheses.size());
  parallel_chunks(static_cast<int>(hypotheses.size()), 4, jobs_, [&](int, int begin, int end) {
    DepthRasterizer rasterizer;
    for (int i = begin; i < end; ++i) {
      const Hypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
      Candidate& candidate = compared[static_cast<std::size_t>(i)];
      const auto index = static_cast<std::size_t>(hypothesis.model);
      candidate.model = hypothesis.model;
      candidate.T_camera_model = hypothesis.T_camera_model;
      candidate.comparison =
          compare_by_rendering(rasterizer, scene_, library_.models()[index],
                               hypothesis.T_camera_model, tolerances_[index].fine);
      if (slide && candidate.comparison.matched_share() > facing_visibility_ &&
          candidate.comparison.badness() < kHopelessBadness) {
        slide_to_silhouette(rasterizer, candidate);
      }
    }
  });
  verified_ += static_cast<int>(hypotheses.size());
  for (Candidate& candidate : compared) {
    if (candidate.comparison.accepts(facing_visibility_)) {
      candidates_.push_back(std::move(candidate));
    }
  }
}

std::vector<const Candidate*> CandidatePool::select() const {
  std::vector<ExplainedSet> sets;
  for (const Candidate& candidate : candidates_) {
    const RenderComparison& comparison = candidate.comparison;
    sets.push_back({comparison.explained, comparison.quality()});
  }
  std::vector<const Candidate*> selected;
  for (const int node : ConflictGraph(std::move(sets), kToleratedOverlap).select_greedily()) {
    selected.push_back(&candidates_[static_cast<std::size_t>(node)]);
  }
  return selected;
}

}  // namespace binpick
