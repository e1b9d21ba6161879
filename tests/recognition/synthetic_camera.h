#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "recognition/synthetic_objects.h"
#include "recognition/synthetic_sensor.h"

namespace binpick::testing {

/// What a shape covers in the image.
struct Coverage {
  int pixels = 0;         ///< if it were alone
  bool in_frame = false;  ///< no part of it leaves the image
};

/// Draws shapes into a clean frame, nearest first, both sides of every triangle. Shares no code
/// with the recognizer's own rasteriser.
class SyntheticCamera {
 public:
  SyntheticCamera(const CameraIntrinsics& intrinsics, const Eigen::Isometry3d& T_world_camera);

  Coverage draw(const Shape& shape, const Eigen::Isometry3d& T_world_shape, std::int16_t owner);

  [[nodiscard]] const CleanFrame& frame() const { return frame_; }

 private:
  struct Corner {
    Eigen::Vector3f p;  // in the camera frame
    float u = 0.0f, v = 0.0f, inverse_z = 0.0f;
  };
  void draw_triangle(const Corner& a, const Corner& b, const Corner& c, std::int16_t owner);

  CleanFrame frame_;
  std::vector<Corner> corners_;
  std::vector<int> drawn_;  // number of the last shape that covered the pixel
  int shapes_ = 0;
  int covered_ = 0;
};

}  // namespace binpick::testing
