#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "models/detection.h"
#include "models/geometry.h"
#include "models/random.h"
#include "models/range_image.h"
#include "recognition/acceptance_model.h"
#include "recognition/model_library.h"
#include "recognition/recognizer_options.h"
#include "recognition/support_plane.h"

namespace binpick {

class ObservedScene;

/// Wall time of one stage, s.
struct StageTiming {
  std::string stage;
  double seconds = 0.0;
};

/// What happened between scene and detections.
struct RecognitionCounters {
  int scene_points = 0;    ///< |S*| before the support planes are removed
  int sampled_points = 0;  ///< n of eq. (11): |S*| off the support planes
  int iterations = 0;      ///< N, pairs asked for
  int pairs = 0;           ///< pairs that had a second point and a usable frame
  int hypotheses = 0;      ///< (M, T) tested
  int accepted = 0;        ///< accepted by mu, before conflicts are removed
  int verified = 0;        ///< compared with the scene by rendering (default setting)
};

/// A hypothesis that was compared with the scene by rendering (default setting); of a selected one
/// what it is in the end.
struct ConsideredHypothesis {
  std::string model;
  /// In the frame of the range image that was searched: for a cloud, the one it was projected to.
  Eigen::Isometry3d T_camera_model = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_scene_model = Eigen::Isometry3d::Identity();  ///< as detections' poses
  HypothesisEvidence evidence;                                      ///< alone
  FeatureVector features{};  ///< on which the decision fell, beside what was selected before it
  double margin = 0.0;       ///< of a selected one: what the best set without it lacks, log odds
  /// Of a selected one: the displacement of its most_uncertain_motion(), diameters.
  double displacement = 0.0;
  bool is_selected = false;
};

struct RecognitionResult {
  /// Best first. Poses are in the frame of the scene: the camera's for a range image, the cloud's
  /// own for a point cloud.
  std::vector<Detection> detections;
  std::vector<SupportPlane> support_planes;  ///< in the frame of the scene
  std::vector<StageTiming> timings;          ///< in order of the stages
  double total_seconds = 0.0;
  RecognitionCounters counters;
  /// All hypotheses that were verified, if RecognizerOptions::keep_considered asks for them.
  std::vector<ConsideredHypothesis> considered;
  /// Why there can be no detection (empty scene, unit mismatch); empty when all is well.
  std::string note;
};

/// The online phase (IJRR 2012, section 4.2, Algorithm 1): finds all instances of all models in one
/// range image at once.
///
/// The default setting differs from the paper as follows: coplanar pairs are dropped and symmetric
/// ones stored once, visibility is relative to the model points that face the sensor, normals must
/// agree, poses are clustered and aligned before they are judged, judged by rendering the model
/// into the range image, and the unexplained rest of the scene is sampled again.
///
/// Thread-safe; the result depends on scene, library, options and seed only, not on `jobs`.
class Recognizer {
 public:
  /// @throws InputError when the options are out of range or ask for another setting than the
  /// library was built for.
  Recognizer(std::shared_ptr<const ModelLibrary> library, RecognizerOptions options);

  /// Recognizes in a range image; poses come in its camera frame.
  /// @throws InputError when the image's size and intrinsics do not fit each other.
  [[nodiscard]] RecognitionResult recognize(const RangeImage& image, Seed seed) const;

  /// Recognizes in a cloud seen from `viewpoint` (in the cloud's frame). An organised cloud whose
  /// points fit a pinhole camera keeps its pixels; any other is projected into a range image whose
  /// focal length follows from the density of its points.
  [[nodiscard]] RecognitionResult recognize(const PointCloud& cloud,
                                            const Eigen::Vector3d& viewpoint, Seed seed) const;

 private:
  [[nodiscard]] RecognitionResult recognize(const RangeImage& image,
                                            const Eigen::Isometry3d& T_scene_camera,
                                            Seed seed) const;

  std::shared_ptr<const ModelLibrary> library_;
  RecognizerOptions options_;
};

}  // namespace binpick
