#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace binpick {

/// One pixel of the scene as the tests read it, in eight bytes.
struct ScenePixel {
  static constexpr std::uint8_t kSupport = 1;  ///< on or below a support plane
  static constexpr std::uint8_t kNormal = 2;   ///< the normal can be relied on

  float depth = 0.0f;  ///< z, m; 0 where nothing was measured
  std::int8_t nx = 0, ny = 0, nz = 0;
  std::uint8_t flags = 0;

  [[nodiscard]] Eigen::Vector3f normal() const {
    constexpr float kScale = 1.0f / 127.0f;
    return {kScale * static_cast<float>(nx), kScale * static_cast<float>(ny),
            kScale * static_cast<float>(nz)};
  }
};

/// Pinhole projection in single precision.
struct Projection {
  int width = 0;
  int height = 0;
  float fx = 0.0f, fy = 0.0f, cx = 0.0f, cy = 0.0f;

  /// The index of the pixel that sees `p`, or -1.
  [[nodiscard]] int pixel(const Eigen::Vector3f& p) const noexcept {
    if (!(p.z() > 0.0f)) return -1;
    const float inverse = 1.0f / p.z();
    const float u = fx * p.x() * inverse + cx + 0.5f;
    const float v = fy * p.y() * inverse + cy + 0.5f;
    if (!(u >= 0.0f && v >= 0.0f && u < static_cast<float>(width) &&
          v < static_cast<float>(height))) {
      return -1;
    }
    return static_cast<int>(v) * width + static_cast<int>(u);
  }
  [[nodiscard]] Eigen::Vector3f point(int u, int v, float depth) const noexcept {
    return {(static_cast<float>(u) - cx) / fx * depth, (static_cast<float>(v) - cy) / fy * depth,
            depth};
  }
  [[nodiscard]] Eigen::Vector3f point(int index, float depth) const noexcept {
    return point(index % width, index / width, depth);
  }
};

}  // namespace binpick
