#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "models/geometry.h"
#include "models/random.h"
#include "models/range_image.h"
#include "recognition/model_library.h"
#include "recognition/synthetic_kinect.h"
#include "recognition/synthetic_objects.h"
#include "recognition/synthetic_parameters.h"
#include "recognition/synthetic_sensor.h"

namespace binpick::testing {

/// Nominal scenes for unit tests.
enum class SceneKind { kSeparate, kPile, kLeaning, kLookAlike, kForeignOnly, kEmptyTable };

/// A known object in the scene and how much of it the sensor sees.
struct TrueInstance {
  std::size_t model = 0;
  Eigen::Isometry3d T_camera_model = Eigen::Isometry3d::Identity();
  /// Pixels that are seen by the camera and lit by the projector, of those it would cover alone.
  double visible_share = 0.0;
  bool in_frame = true;  ///< no part leaves the image
};

struct SyntheticScene {
  CleanFrame clean;
  std::vector<TrueInstance> instances;
};

/// A scan as the recognizer gets it, and the truth.
struct SyntheticFrame {
  SceneParameters parameters;
  SyntheticScene scene;
  RangeImage image;  ///< what the sensor measured
  /// The same as a cloud, in the form that the parameters ask for; empty for a range image.
  PointCloud cloud;
  Eigen::Isometry3d T_scene_camera = Eigen::Isometry3d::Identity();  ///< scene: the cloud's frame
  Eigen::Vector3d p_scene_viewpoint = Eigen::Vector3d::Zero();       ///< as stated with the cloud
};

/// Objects on a table, seen by one depth sensor. Objects come down vertically until they touch what
/// lies there, so that none penetrates another. The same seed gives the same scene.
class SceneGenerator {
 public:
  explicit SceneGenerator(std::vector<ModelSource> known);

  /// The scene before the sensor.
  [[nodiscard]] SyntheticScene make(const SceneParameters& parameters, Seed seed) const;
  [[nodiscard]] SyntheticScene make(SceneKind kind, Seed seed) const;

  /// The scene as scanned.
  [[nodiscard]] SyntheticFrame frame(const SceneParameters& parameters, Seed seed) const;

  [[nodiscard]] const std::vector<ModelSource>& known() const noexcept { return known_; }

 private:
  std::vector<ModelSource> known_;
  std::vector<Shape> known_shapes_;
};

}  // namespace binpick::testing
