#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "models/random.h"
#include "recognition/model_library.h"
#include "recognition/synthetic_kinect.h"

namespace binpick::testing {

enum class SceneKind { kSeparate, kPile, kLeaning, kLookAlike, kForeignOnly, kEmptyTable };

/// A known object in the scene and how much of it the camera sees.
struct TrueInstance {
  std::size_t model = 0;
  Eigen::Isometry3d T_camera_model = Eigen::Isometry3d::Identity();
  double visible_share = 0.0;  ///< of the pixels it would cover alone
  bool in_frame = true;        ///< no part leaves the image
};

struct SyntheticScene {
  CleanFrame clean;
  std::vector<TrueInstance> instances;
};

/// Objects on a table of 1.3 m x 0.9 m, seen by a 640 x 480 camera 0.774 m above it that looks down
/// at 33.6 degrees off the table's normal. Objects come down vertically until they touch what lies
/// there, so that none penetrates another.
class SceneGenerator {
 public:
  explicit SceneGenerator(std::vector<ModelSource> known);

  [[nodiscard]] SyntheticScene make(SceneKind kind, Seed seed) const;

 private:
  std::vector<ModelSource> known_;
  std::vector<RecognitionModel> known_shapes_;
  std::vector<RecognitionModel> foreign_shapes_;
};

}  // namespace binpick::testing
