#pragma once

#include <vector>

#include "recognition/scene_pixel.h"

namespace binpick {

/// What a scene tells about the sensor that took it, at the working resolution. Nothing here is
/// asked of the user.
struct SensorEstimate {
  /// Standard deviation of the depth of a surface that faces the sensor: sqrt(constant^2 +
  /// (quadratic z^2)^2), m. Laser scanners show the first term, triangulating sensors the second.
  float constant = 0.0f;
  float quadratic = 0.0f;  ///< 1/m
  /// By how many pixels a measured ray may lie beside its own: noise on surfaces seen at a slant.
  float lateral = 0.0f;
  /// Pixels over whose noise errors are alike: the sum of the spatial autocorrelation.
  float correlated_pixels = 1.0f;

  /// Variance of the depth at `z`, m^2.
  [[nodiscard]] float axial_variance(float z) const noexcept {
    const float triangulation = quadratic * z * z;
    return constant * constant + triangulation * triangulation;
  }
  /// Variance of the distance of a measured point from a surface along the surface's normal.
  /// `n_ray` is normal . (x / z, y / z, 1); `pixel` the width of a pixel at z = 1, 1 / f.
  [[nodiscard]] float normal_variance(float z, float n_ray, float pixel) const noexcept {
    const float jitter = lateral * pixel * z;
    const float slant = 1.0f - n_ray * n_ray;
    return n_ray * n_ray * axial_variance(z) + jitter * jitter * (slant > 0.0f ? slant : 0.0f);
  }
};

/// Estimates the sensor's noise from second differences of the inverse depth, which vanish on
/// planes: robustly, over the whole image of `projection`, by depth and by slant. Of an image
/// without usable pixels axial noise remains 0. O(pixels).
[[nodiscard]] SensorEstimate estimate_sensor(const Projection& projection,
                                             const std::vector<ScenePixel>& pixels, int jobs = 1);

}  // namespace binpick
