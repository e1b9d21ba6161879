#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace binpick {

/// Pinhole calibration. Pixel (u, v) = (fx x/z + cx, fy y/z + cy) with integer values at pixel
/// centres; the camera frame has x right, y down, z along the optical axis.
struct CameraIntrinsics {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
};

/// What a depth camera delivers, and all that the robot's brain gets to see of the scene.
struct RangeImage {
  CameraIntrinsics intrinsics;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  /// Row-major, z along the optical axis in metres; 0 where nothing was measured.
  std::vector<float> depth;

  [[nodiscard]] float at(int u, int v) const noexcept {
    return depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(intrinsics.width) +
                 static_cast<std::size_t>(u)];
  }
  /// The point seen by pixel (u, v), in the camera frame; z = 0 where nothing was measured.
  [[nodiscard]] Eigen::Vector3d p_camera(int u, int v) const noexcept {
    const double z = at(u, v);
    return {(u - intrinsics.cx) / intrinsics.fx * z, (v - intrinsics.cy) / intrinsics.fy * z, z};
  }
};

}  // namespace binpick
