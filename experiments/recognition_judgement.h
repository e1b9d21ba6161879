#pragma once

#include <Eigen/Geometry>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "experiments/recognition_scenes.h"
#include "models/detection.h"
#include "models/object_model.h"
#include "recognition/pose_metrics.h"

namespace binpick {

/// The true objects of a view and what was found of them.
struct RecognitionJudgement {
  struct Match {
    std::size_t detection = 0;
    std::size_t object = 0;
    double mssd = 0.0;  ///< m
    PoseError error;    ///< under the symmetry nearest the truth
  };
  std::vector<Match> matches;
  std::size_t false_positives = 0;  ///< detections that match no object, or one found already

  /// The match of object `i`; null when it was not found.
  [[nodiscard]] const Match* match_of(std::size_t object) const;
};

/// Compares detections with the truth. A detection is right if its MSSD to an object of its model
/// is below a tenth of the model's diameter; each object is found once, by the detection nearest to
/// it (match_instances).
class RecognitionJudge {
 public:
  /// `objects` as they are searched, whatever the scale of the recognizer's own models.
  explicit RecognitionJudge(const std::vector<ObjectModel>& objects);

  /// `detections` in the camera's frame.
  [[nodiscard]] RecognitionJudgement judge(std::span<const Detection> detections,
                                           std::span<const TrueObject> objects) const;

  /// The poses that the shape of `model` cannot tell apart.
  [[nodiscard]] const std::vector<Eigen::Isometry3d>& symmetries(const std::string& model) const {
    return shapes_.at(model).symmetries;
  }

 private:
  struct Shape {
    std::vector<Eigen::Vector3f> points;  ///< vertices, thinned out
    std::vector<Eigen::Isometry3d> symmetries;
    double diameter = 0.0;
  };
  std::map<std::string, Shape> shapes_;
};

}  // namespace binpick
