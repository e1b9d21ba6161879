#include "experiments/recognition_judgement.h"

#include <algorithm>
#include <tuple>

namespace binpick {
namespace {

/// Largest share of the diameter that a right pose may be off.
constexpr double kCorrectShare = 0.1;
/// Vertices per model that the errors are taken over.
constexpr std::size_t kMostPoints = 600;

double diameter_of(const std::vector<Eigen::Vector3f>& points) {
  float longest = 0.0f;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (points[i] - points[j]).norm());
  }
  return longest;
}

}  // namespace

const RecognitionJudgement::Match* RecognitionJudgement::match_of(std::size_t object) const {
  const auto found = std::find_if(matches.begin(), matches.end(),
                                  [&](const Match& match) { return match.object == object; });
  return found == matches.end() ? nullptr : &*found;
}

RecognitionJudge::RecognitionJudge(const std::vector<ObjectModel>& objects) {
  for (const ObjectModel& object : objects) {
    Shape& shape = shapes_[object.name];
    const std::vector<Eigen::Vector3d>& vertices = object.mesh.vertices;
    const std::size_t stride = 1 + vertices.size() / kMostPoints;
    for (std::size_t i = 0; i < vertices.size(); i += stride) {
      shape.points.emplace_back(vertices[i].cast<float>());
    }
    shape.symmetries = object.symmetries;
    shape.diameter = diameter_of(shape.points);
  }
}

RecognitionJudgement RecognitionJudge::judge(std::span<const Detection> detections,
                                             std::span<const TrueObject> objects) const {
  std::vector<RecognitionJudgement::Match> candidates;
  for (std::size_t d = 0; d < detections.size(); ++d) {
    const Shape& shape = shapes_.at(detections[d].model);
    const Eigen::Isometry3d& T = detections[d].T_scene_model;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (objects[i].model != detections[d].model) continue;
      const double distance = mssd(T, objects[i].T_camera_model, shape.points, shape.symmetries);
      if (distance < kCorrectShare * shape.diameter) candidates.push_back({d, i, distance, {}});
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::tie(a.mssd, a.detection, a.object) < std::tie(b.mssd, b.detection, b.object);
  });
  RecognitionJudgement result;
  for (RecognitionJudgement::Match& match : candidates) {
    const auto clashes = [&](const RecognitionJudgement::Match& other) {
      return other.detection == match.detection || other.object == match.object;
    };
    if (std::any_of(result.matches.begin(), result.matches.end(), clashes)) continue;
    match.error =
        pose_error(detections[match.detection].T_scene_model, objects[match.object].T_camera_model,
                   shapes_.at(detections[match.detection].model).symmetries);
    result.matches.push_back(match);
  }
  result.false_positives = detections.size() - result.matches.size();
  return result;
}

}  // namespace binpick
