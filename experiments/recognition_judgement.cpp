#include "experiments/recognition_judgement.h"

#include <algorithm>
#include <limits>

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
  // MSSD as a share of the model's diameter.
  Eigen::MatrixXd error = Eigen::MatrixXd::Constant(std::ssize(detections), std::ssize(objects),
                                                    std::numeric_limits<double>::infinity());
  for (std::size_t d = 0; d < detections.size(); ++d) {
    const Shape& shape = shapes_.at(detections[d].model);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (objects[i].model != detections[d].model) continue;
      error(Eigen::Index(d), Eigen::Index(i)) =
          mssd(detections[d].T_scene_model, objects[i].T_camera_model, shape.points,
               shape.symmetries) /
          shape.diameter;
    }
  }
  // The detection nearest to an object scores best: a worse one must not take the object from it.
  std::vector<double> scores;
  for (Eigen::Index d = 0; d < error.rows(); ++d) {
    scores.push_back(error.cols() == 0 ? 0.0 : -error.row(d).minCoeff());
  }
  const InstanceMatching matching = match_instances(
      scores, objects.size(), kCorrectShare,
      [&](std::size_t d, std::size_t i) { return error(Eigen::Index(d), Eigen::Index(i)); });
  RecognitionJudgement result;
  result.false_positives = matching.false_positives();
  for (std::size_t d = 0; d < detections.size(); ++d) {
    if (matching.truth_of[d] < 0) continue;
    const auto i = static_cast<std::size_t>(matching.truth_of[d]);
    const Shape& shape = shapes_.at(detections[d].model);
    result.matches.push_back(
        {d, i, error(Eigen::Index(d), Eigen::Index(i)) * shape.diameter,
         pose_error(detections[d].T_scene_model, objects[i].T_camera_model, shape.symmetries)});
  }
  return result;
}

}  // namespace binpick
