#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// A model drawn into a window of an image: depth and the triangle seen, per pixel.
struct RenderedModel {
  int u0 = 0, v0 = 0;  ///< the window's first pixel in the image
  int width = 0, height = 0;
  float nearest = 0.0f;                ///< depth of the nearest vertex, m
  std::vector<float> depth;            ///< z, m; 0 outside the model
  std::vector<std::int32_t> triangle;  ///< -1 outside the model

  [[nodiscard]] std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(u);
  }
  /// Whether the model covers the window's pixel (u, v); false outside the window.
  [[nodiscard]] bool covers(int u, int v) const {
    return u >= 0 && v >= 0 && u < width && v < height && depth[index(u, v)] > 0.0f;
  }
};

/// Draws triangles as a pinhole camera sees them, nearest first, sampled at pixel centres with
/// perspective-correct depth; triangles that face away are skipped. Works by spans: per triangle
/// and row one interval of pixels. Keeps its buffers between calls: one object per thread.
class DepthRasterizer {
 public:
  /// The result is valid until the next call. O(vertices + triangles + covered pixels).
  const RenderedModel& render(const RenderMesh& mesh, const Eigen::Isometry3f& T_camera_model,
                              const Projection& projection);

 private:
  void project(const RenderMesh& mesh, const Eigen::Isometry3f& T_camera_model,
               const Projection& projection);
  void draw(const std::array<std::int32_t, 3>& corners, std::int32_t triangle);

  RenderedModel rendered_;
  std::vector<Eigen::Vector3f> projected_;  // u, v, 1 / z
};

}  // namespace binpick
