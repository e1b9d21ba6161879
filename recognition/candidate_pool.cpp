#include "recognition/candidate_pool.h"

#include <algorithm>
#include <array>

#include "recognition/conflict_graph.h"
#include "recognition/parallel_for.h"
#include "recognition/pose_refinement.h"
#include "recognition/projective_alignment.h"

namespace binpick {
namespace {

constexpr double kHopelessBadness = 0.4;   // no sliding helps
constexpr double kToleratedOverlap = 0.2;  // of the smaller explained set

}  // namespace

CandidatePool::CandidatePool(const ModelLibrary& library, const ObservedScene& scene,
                             double visibility, int jobs)
    : library_(library), scene_(scene), facing_visibility_(1.2 * visibility), jobs_(jobs) {
  for (const RecognitionModel& model : library.models()) {
    tolerances_.push_back(tolerances_for(model, scene.noise()));
  }
}

void CandidatePool::add(std::vector<Hypothesis> hypotheses, int most_per_model, bool slide) {
  const std::vector<Hypothesis> fresh =
      cluster_and_align(std::move(hypotheses), library_.models(), scene_,
                        {most_per_model, facing_visibility_, jobs_}, tried_);
  tried_.insert(tried_.end(), fresh.begin(), fresh.end());
  verify(fresh, slide);
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
