#include "recognition/synthetic_kinect.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace binpick::testing {
namespace {

/// Gaussian noise with unit deviation that is alike over `cell` pixels (bilinear).
class NoiseField {
 public:
  NoiseField(int width, int height, int cell, Seed seed) : cell_(cell), columns_(width / cell + 2) {
    Random random(seed);
    const int rows = height / cell + 2;
    for (int i = 0; i < rows * columns_; ++i) knots_.push_back(random.normal());
  }
  [[nodiscard]] double at(int u, int v) const {
    const double x = static_cast<double>(u) / cell_;
    const double y = static_cast<double>(v) / cell_;
    const int i = static_cast<int>(x);
    const int j = static_cast<int>(y);
    const double a = x - i;
    const double b = y - j;
    const double norm = std::sqrt((a * a + (1 - a) * (1 - a)) * (b * b + (1 - b) * (1 - b)));
    return ((1 - b) * ((1 - a) * knot(i, j) + a * knot(i + 1, j)) +
            b * ((1 - a) * knot(i, j + 1) + a * knot(i + 1, j + 1))) /
           norm;
  }

 private:
  [[nodiscard]] double knot(int i, int j) const {
    return knots_[static_cast<std::size_t>(j * columns_ + i)];
  }
  int cell_;
  int columns_;
  std::vector<double> knots_;
};

std::size_t index_of(const RangeImage& image, int u, int v) {
  u = std::clamp(u, 0, image.intrinsics.width - 1);
  v = std::clamp(v, 0, image.intrinsics.height - 1);
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(image.intrinsics.width) +
         static_cast<std::size_t>(u);
}

/// Which pixel of the clean frame a pixel shows: displaced raggedly, and drawn to nearer surfaces.
std::size_t shown_pixel(const CleanFrame& clean, const KinectNoise& noise, int u, int v,
                        const NoiseField& shift_u, const NoiseField& shift_v,
                        const NoiseField& growth) {
  const int su = u + static_cast<int>(std::lround(0.7 * shift_u.at(u, v)));
  const int sv = v + static_cast<int>(std::lround(0.7 * shift_v.at(u, v)));
  const int reach = static_cast<int>(std::clamp(
      std::floor(0.5 * noise.most_dilation + 0.6 * growth.at(u, v)), 0.0, noise.most_dilation));
  std::size_t shown = index_of(clean.image, su, sv);
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      const std::size_t other = index_of(clean.image, su + du, sv + dv);
      const float z = clean.image.depth[other];
      const float shown_z = clean.image.depth[shown];
      if (z > 0.0f && (shown_z == 0.0f || z < 0.98f * shown_z)) shown = other;
    }
  }
  return shown;
}

/// Marks pixels that the projector, to the right of the camera, does not light.
void drop_shadows(RangeImage& image, const RangeImage& clean, double baseline) {
  const double fb = clean.intrinsics.fx * baseline;
  for (int v = 0; v < clean.intrinsics.height; ++v) {
    double leftmost = 1e9;
    for (int u = clean.intrinsics.width - 1; u >= 0; --u) {
      const double z = clean.at(u, v);
      if (!(z > 0.0)) continue;
      const double in_projector = u - fb / z;
      if (in_projector > leftmost + 1.0) image.depth[index_of(image, u, v)] = 0.0f;
      leftmost = std::min(leftmost, in_projector);
    }
  }
}

}  // namespace

RangeImage add_kinect_noise(const CleanFrame& clean, const KinectNoise& noise, Seed seed) {
  const int width = clean.image.intrinsics.width;
  const int height = clean.image.intrinsics.height;
  const NoiseField shift_u(width, height, 3, derive_seed(seed, "shift u"));
  const NoiseField shift_v(width, height, 3, derive_seed(seed, "shift v"));
  const NoiseField growth(width, height, 5, derive_seed(seed, "growth"));
  const NoiseField fine(width, height, 2, derive_seed(seed, "fine"));
  const NoiseField coarse(width, height, 6, derive_seed(seed, "coarse"));
  const NoiseField slow(width, height, 200, derive_seed(seed, "slow"));
  Random random(derive_seed(seed, "pixels"));
  const double fb = clean.image.intrinsics.fx * noise.baseline;
  RangeImage image = clean.image;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double mixing = random.uniform();
      const double dropping = random.uniform();
      const std::size_t shown = shown_pixel(clean, noise, u, v, shift_u, shift_v, growth);
      float& depth = image.depth[index_of(image, u, v)];
      double z = clean.image.depth[shown];
      depth = 0.0f;
      if (!(z > 0.0)) continue;
      if (clean.cosine[shown] < noise.grazing_cosine && dropping < 0.8) continue;
      const double own = clean.image.at(u, v);
      if (own > 1.03 * z && mixing < noise.mixed_pixels)
        z += (own - z) * mixing / noise.mixed_pixels;
      z += noise.bow * std::clamp(0.6 * slow.at(u, v), -1.0, 1.0);
      z += noise.axial_sigma * z * z * (0.6 * fine.at(u, v) + 0.8 * coarse.at(u, v));
      const double disparity = std::round(fb / z / noise.disparity_step) * noise.disparity_step;
      depth = static_cast<float>(fb / disparity);
    }
  }
  drop_shadows(image, clean.image, noise.baseline);
  return image;
}

}  // namespace binpick::testing
