#include "recognition/hypothesis_clusters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "recognition/acceptance_function.h"
#include "recognition/parallel_for.h"
#include "recognition/projective_alignment.h"

namespace binpick {
namespace {

constexpr float kClusterShare = 0.12f;     // of the diameter, before alignment
constexpr float kConvergedShare = 0.03f;   // of the diameter, between coarse and fine alignment
constexpr float kDuplicateShare = 0.04f;   // of the diameter, after alignment
constexpr float kSamePlace = 0.35f;        // of the diameter
constexpr std::size_t kHeadsPerKept = 10;  // found before few are kept: bounds the cost
constexpr float kMostOccluding = 0.15f;    // of the points that face the sensor

/// A pose as distances between poses read it.
struct LocatedPose {
  Eigen::Isometry3f T;
  Eigen::Quaternionf rotation;
  Eigen::Vector3f fixed_point;  // of the model's symmetries, camera frame
};

/// How far the corners of the model's bounding box are apart in two poses, the nearest of the
/// equivalent ones counting. Most pairs of poses are told apart by a point that no symmetry moves
/// or by the angle of the relative rotation, before any corner is moved.
class PoseDistance {
 public:
  explicit PoseDistance(const RecognitionModel& model) {
    Eigen::Vector3f orbit = Eigen::Vector3f::Zero();
    for (const Eigen::Isometry3d& symmetry : model.symmetries) {
      symmetries_.push_back(symmetry.cast<float>());
      rotations_.emplace_back(symmetries_.back().linear());
      orbit += symmetries_.back() * model.centre;
    }
    fixed_point_ = orbit / static_cast<float>(symmetries_.size());
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : model.hull) box.extend(p);
    for (int corner = 0; corner < 8; ++corner) {
      corners_.push_back(box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)));
    }
    // Corners lie in pairs opposite to each other, so a rotation moves one of each pair at least as
    // far as about the centre; some corner is this far from any axis.
    Eigen::Vector3f sides = box.sizes();
    std::sort(sides.data(), sides.data() + 3);
    constexpr float kMargin = 0.7f;
    lever_ = kMargin * 0.5f * sides.head<2>().norm();
  }

  [[nodiscard]] LocatedPose locate(const Eigen::Isometry3f& T) const {
    return {T, Eigen::Quaternionf(T.linear()), T * fixed_point_};
  }

  [[nodiscard]] bool closer(const LocatedPose& a, const LocatedPose& b, float limit) const {
    if ((a.fixed_point - b.fixed_point).squaredNorm() > limit * limit) return false;
    const Eigen::Quaternionf between = a.rotation.conjugate() * b.rotation;
    for (std::size_t i = 0; i < symmetries_.size(); ++i) {
      const Eigen::Quaternionf& s = rotations_[i];
      const float cosine = between.w() * s.w() - between.vec().dot(s.vec());  // of half the angle
      const float sine = std::sqrt(std::max(1.0f - cosine * cosine, 0.0f));
      if (2.0f * sine * lever_ > limit) continue;
      const Eigen::Isometry3f equivalent = b.T * symmetries_[i];
      const bool close =
          std::all_of(corners_.begin(), corners_.end(), [&](const Eigen::Vector3f& p) {
            return (a.T * p - equivalent * p).squaredNorm() < limit * limit;
          });
      if (close) return true;
    }
    return false;
  }

 private:
  std::vector<Eigen::Isometry3f> symmetries_;
  std::vector<Eigen::Quaternionf> rotations_;
  Eigen::Vector3f fixed_point_;
  std::vector<Eigen::Vector3f> corners_;
  float lever_ = 0.0f;
};

/// Which hypotheses of a model, given best first, lie at one place in the scene.
class Places {
 public:
  explicit Places(float radius) : squared_radius_(radius * radius) {}

  /// The next hypothesis, best first.
  void add(const Eigen::Vector3f& p) {
    const auto place = std::find_if(places_.begin(), places_.end(), [&](const Place& other) {
      return (other.p - p).squaredNorm() < squared_radius_;
    });
    if (place == places_.end()) {
      places_.push_back({p, 1});
      ranks_.push_back(0);
    } else {
      ranks_.push_back(place->count++);
    }
  }

  /// Keeps the best of every place, then the second best, and so on, until there are `most`.
  void keep_best_of_each(std::vector<Hypothesis>& hypotheses, std::size_t most) const {
    if (hypotheses.size() <= most) return;
    std::vector<std::size_t> order(hypotheses.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return ranks_[a] < ranks_[b]; });
    order.resize(most);
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < most; ++i) hypotheses[i] = hypotheses[order[i]];
    hypotheses.resize(most);
  }

 private:
  struct Place {
    Eigen::Vector3f p;
    int count;
  };
  float squared_radius_;
  std::vector<Place> places_;
  std::vector<int> ranks_;  // of each hypothesis at its place
};

void align_coarsely(std::vector<Hypothesis>& hypotheses,
                    const std::vector<RecognitionModel>& models, const ObservedScene& scene,
                    int jobs) {
  parallel_chunks(static_cast<int>(hypotheses.size()), 4, jobs, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Hypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
      const RecognitionModel& model = models[static_cast<std::size_t>(hypothesis.model)];
      const float coarse = tolerances_for(model, scene.noise()).coarse;
      hypothesis.T_camera_model =
          align_projectively(scene, model, hypothesis.T_camera_model, {1.5f * coarse, 128, 4});
    }
  });
}

/// Aligns every hypothesis finely and keeps those that stand an exact test with that tolerance.
std::vector<Hypothesis> align_finely(std::vector<Hypothesis> hypotheses,
                                     const std::vector<RecognitionModel>& models,
                                     const ObservedScene& scene, const ClusteringOptions& options) {
  std::vector<char> stands(hypotheses.size(), 0);
  parallel_chunks(
      static_cast<int>(hypotheses.size()), 2, options.jobs, [&](int, int begin, int end) {
        for (int i = begin; i < end; ++i) {
          Hypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
          const auto index = static_cast<std::size_t>(hypothesis.model);
          const RecognitionModel& model = models[index];
          const ModelTolerances tolerance = tolerances_for(model, scene.noise());
          const Eigen::Isometry3f T = align_projectively(scene, model, hypothesis.T_camera_model,
                                                         fine_alignment(tolerance.fine));
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
                                           int most, int jobs,
                                           const std::vector<Hypothesis>& known) {
  std::vector<std::vector<Hypothesis>> of_model(models.size());
  for (const Hypothesis& h : hypotheses) of_model[static_cast<std::size_t>(h.model)].push_back(h);
  std::vector<std::size_t> costs;
  for (const auto& candidates : of_model) costs.push_back(candidates.size());
  parallel_for_longest_first(costs, jobs, [&](int model) {
    std::vector<Hypothesis>& candidates = of_model[static_cast<std::size_t>(model)];
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    const RecognitionModel& shape = models[static_cast<std::size_t>(model)];
    const PoseDistance distance(shape);
    const float limit = share * shape.diameter;
    std::vector<LocatedPose> taken;  // known ones, then heads
    for (const Hypothesis& other : known) {
      if (other.model == model) taken.push_back(distance.locate(other.T_camera_model));
    }
    std::size_t heads = 0;
    Places places(kSamePlace * shape.diameter);
    for (const Hypothesis& candidate : candidates) {
      if (heads == kHeadsPerKept * static_cast<std::size_t>(most)) break;
      const LocatedPose pose = distance.locate(candidate.T_camera_model);
      const bool is_known = std::any_of(taken.begin(), taken.end(), [&](const LocatedPose& other) {
        return distance.closer(pose, other, limit);
      });
      if (is_known) continue;
      taken.push_back(pose);
      places.add(pose.fixed_point);
      candidates[heads++] = candidate;
    }
    candidates.resize(heads);
    places.keep_best_of_each(candidates, static_cast<std::size_t>(most));
  });
  std::vector<Hypothesis> heads;
  for (const auto& kept : of_model) heads.insert(heads.end(), kept.begin(), kept.end());
  return heads;
}

std::vector<Hypothesis> cluster_and_align(std::vector<Hypothesis> hypotheses,
                                          const std::vector<RecognitionModel>& models,
                                          const ObservedScene& scene,
                                          const ClusteringOptions& options,
                                          const std::vector<Hypothesis>& known) {
  std::vector<Hypothesis> heads = keep_cluster_heads(std::move(hypotheses), models, kClusterShare,
                                                     options.most_per_model, options.jobs);
  align_coarsely(heads, models, scene, options.jobs);
  // What has converged to one pose needs one fine alignment.
  heads = keep_cluster_heads(std::move(heads), models, kConvergedShare, options.most_per_model,
                             options.jobs);
  return keep_cluster_heads(align_finely(std::move(heads), models, scene, options), models,
                            kDuplicateShare, options.most_per_model, options.jobs, known);
}

}  // namespace binpick
