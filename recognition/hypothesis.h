#pragma once

#include <Eigen/Geometry>

namespace binpick {

/// (M, T): the model with index `model` may be in the scene at this pose.
struct Hypothesis {
  int model = 0;
  Eigen::Isometry3f T_camera_model = Eigen::Isometry3f::Identity();
  float score = 0.0f;  ///< larger is better; comparable within one model
};

}  // namespace binpick
