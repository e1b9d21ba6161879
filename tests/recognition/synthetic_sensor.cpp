#include "recognition/synthetic_sensor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace binpick::testing {
namespace {

constexpr float kSameSurface = 0.02f;  // relative difference of depths of one surface, at most

/// Gaussian noise with unit deviation that is alike over `cell` pixels (bilinear).
class NoiseField {
 public:
  NoiseField(const CameraIntrinsics& camera, int cell, Seed seed)
      : cell_(cell), columns_(camera.width / cell + 2) {
    Random random(seed);
    const int rows = camera.height / cell + 2;
    for (int i = 0; i < rows * columns_; ++i) knots_.push_back(random.normal());
    for (int i = 0; i < cell; ++i) {
      const double a = static_cast<double>(i) / cell;
      share_.push_back(a);
      norm_.push_back(1.0 / std::sqrt(a * a + (1 - a) * (1 - a)));
    }
  }
  [[nodiscard]] double at(int u, int v) const {
    const int i = u / cell_;
    const int j = v / cell_;
    const auto du = static_cast<std::size_t>(u - i * cell_);
    const auto dv = static_cast<std::size_t>(v - j * cell_);
    const double a = share_[du];
    const double b = share_[dv];
    return ((1 - b) * ((1 - a) * knot(i, j) + a * knot(i + 1, j)) +
            b * ((1 - a) * knot(i, j + 1) + a * knot(i + 1, j + 1))) *
           norm_[du] * norm_[dv];
  }

 private:
  [[nodiscard]] double knot(int i, int j) const {
    return knots_[static_cast<std::size_t>(j * columns_ + i)];
  }
  int cell_;
  int columns_;
  std::vector<double> knots_;
  std::vector<double> share_, norm_;
};

/// Row-major access that stays inside the image.
class Grid {
 public:
  explicit Grid(const CameraIntrinsics& camera) : width_(camera.width), height_(camera.height) {}
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::size_t operator()(int u, int v) const {
    u = std::clamp(u, 0, width_ - 1);
    v = std::clamp(v, 0, height_ - 1);
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }

 private:
  int width_, height_;
};

/// 1 where the depths within `reach` pixels are not of one surface.
std::vector<std::uint8_t> near_edges(const std::vector<float>& depth, const Grid& grid, int reach) {
  std::vector<float> least(depth.size()), most(depth.size());
  const auto spread = [&](const auto& low_at, const auto& high_at, auto& low_out, auto& high_out,
                          int step_u, int step_v) {
    for (int v = 0; v < grid.height(); ++v) {
      for (int u = 0; u < grid.width(); ++u) {
        float low = std::numeric_limits<float>::infinity();
        float high = 0.0f;
        for (int i = -reach; i <= reach; ++i) {
          const std::size_t other = grid(u + i * step_u, v + i * step_v);
          low = std::min(low, low_at[other]);
          high = std::max(high, high_at[other]);
        }
        low_out[grid(u, v)] = low;
        high_out[grid(u, v)] = high;
      }
    }
  };
  spread(depth, depth, least, most, 1, 0);
  std::vector<float> lowest(depth.size()), highest(depth.size());
  spread(least, most, lowest, highest, 0, 1);
  std::vector<std::uint8_t> edges(depth.size());
  for (std::size_t i = 0; i < depth.size(); ++i) {
    edges[i] = lowest[i] < (1.0f - kSameSurface) * highest[i];
  }
  return edges;
}

/// Depth as the mean over the sensor's window, other surfaces left out.
std::vector<float> windowed(const std::vector<float>& depth, const Grid& grid, int radius) {
  if (radius == 0) return depth;
  std::vector<float> mean(depth.size(), 0.0f);
  for (int v = 0; v < grid.height(); ++v) {
    for (int u = 0; u < grid.width(); ++u) {
      const float z = depth[grid(u, v)];
      if (!(z > 0.0f)) continue;
      float sum = 0.0f;
      float count = 0.0f;
      for (int dv = -radius; dv <= radius; ++dv) {
        for (int du = -radius; du <= radius; ++du) {
          const float other = depth[grid(u + du, v + dv)];
          const float same = std::abs(other - z) < kSameSurface * z ? 1.0f : 0.0f;
          sum += same * (other - z);
          count += same;
        }
      }
      mean[grid(u, v)] = z + sum / count;
    }
  }
  return mean;
}

/// The random fields and masks of one frame.
class Sensor {
 public:
  Sensor(const CleanFrame& clean, const SensorNoise& noise, Seed seed)
      : clean_(clean),
        noise_(noise),
        grid_(clean.image.intrinsics),
        shift_u_(clean.image.intrinsics, 3, derive_seed(seed, "shift u")),
        shift_v_(clean.image.intrinsics, 3, derive_seed(seed, "shift v")),
        growth_(clean.image.intrinsics, 5, derive_seed(seed, "growth")),
        fine_(clean.image.intrinsics, 2, derive_seed(seed, "fine")),
        coarse_(clean.image.intrinsics, 6, derive_seed(seed, "coarse")),
        slow_(clean.image.intrinsics, 200, derive_seed(seed, "slow")),
        patches_(clean.image.intrinsics, 12, derive_seed(seed, "patches")),
        random_(derive_seed(seed, "pixels")),
        depth_(windowed(clean.image.depth, grid_, noise.window)),
        edges_(near_edges(clean.image.depth, grid_,
                          static_cast<int>(std::ceil(noise.most_dilation)) + 2)) {}

  RangeImage measure() {
    RangeImage image = clean_.image;
    const double fb = image.intrinsics.fx * noise_.baseline;
    for (int v = 0; v < grid_.height(); ++v) {
      for (int u = 0; u < grid_.width(); ++u) {
        double z = measured_depth(u, v);
        if (z > 0.0 && noise_.disparity_step > 0.0) {
          const double disparity =
              std::round(fb / z / noise_.disparity_step) * noise_.disparity_step;
          z = disparity > 0.0 ? fb / disparity : 0.0;
        }
        image.depth[grid_(u, v)] = static_cast<float>(z);
      }
    }
    drop_shadows(image);
    return image;
  }

 private:
  /// Which pixel of the clean frame a pixel shows: displaced raggedly, drawn to nearer surfaces.
  [[nodiscard]] std::size_t shown_pixel(int u, int v) const {
    if (edges_[grid_(u, v)] == 0) return grid_(u, v);
    const int su = u + static_cast<int>(std::lround(noise_.raggedness * shift_u_.at(u, v)));
    const int sv = v + static_cast<int>(std::lround(noise_.raggedness * shift_v_.at(u, v)));
    const double least = noise_.least_dilation;
    const double most = std::max(noise_.most_dilation, least);
    const int reach = static_cast<int>(
        std::clamp(std::floor(0.5 * (least + most) + 0.6 * growth_.at(u, v)), least, most));
    const std::vector<float>& depth = clean_.image.depth;
    std::size_t shown = grid_(su, sv);
    for (int dv = -reach; dv <= reach; ++dv) {
      for (int du = -reach; du <= reach; ++du) {
        const std::size_t other = grid_(su + du, sv + dv);
        const float z = depth[other];
        if (z > 0.0f && (depth[shown] == 0.0f || z < (1.0f - kSameSurface) * depth[shown])) {
          shown = other;
        }
      }
    }
    return shown;
  }

  [[nodiscard]] double sigma(double z, double cosine) const {
    const double theta = std::acos(std::clamp(cosine, 0.17, 1.0));  // at most 80 degrees
    const double rest = 0.5 * std::numbers::pi - theta;
    return noise_.sigma_0 + z * (noise_.sigma_1 + z * noise_.sigma_2) +
           noise_.grazing_sigma * theta * theta / (rest * rest) / std::sqrt(z);
  }

  [[nodiscard]] double measured_depth(int u, int v) {
    const double mixing = random_.uniform();
    const double dropping = random_.uniform();
    const std::size_t shown = shown_pixel(u, v);
    double z = depth_[shown];
    if (!(z > 0.0) || is_shiny(u, v)) return 0.0;
    const double cosine = clean_.cosine[shown];
    if (cosine < noise_.grazing_cosine && dropping < 0.8) return 0.0;
    if (edges_[grid_(u, v)] != 0 && mixing < noise_.mixed_pixels) {
      const double behind = depth_behind(u, v, z);
      z += (behind - z) * mixing / noise_.mixed_pixels;
    }
    z += noise_.bow * std::clamp(0.6 * slow_.at(u, v), -1.0, 1.0);
    const double unit = std::sqrt(1.0 - noise_.correlated) * fine_.at(u, v) +
                        std::sqrt(noise_.correlated) * coarse_.at(u, v);
    return std::max(z + sigma(z, cosine) * unit, 0.0);
  }

  /// The depth of the farther surface that touches pixel (u, v); z when there is none.
  [[nodiscard]] double depth_behind(int u, int v, double z) const {
    double behind = z;
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        behind = std::max(behind, static_cast<double>(clean_.image.depth[grid_(u + du, v + dv)]));
      }
    }
    return behind > 1.03 * z ? behind : z;
  }

  [[nodiscard]] bool is_shiny(int u, int v) const {
    if (!(noise_.shiny_share > 0.0)) return false;
    // The upper quantile of a normal variable, good to a tenth for shares of 0.001 to 0.1.
    const double t = std::sqrt(-2.0 * std::log(noise_.shiny_share));
    const double quantile = t - (2.30753 + 0.27061 * t) / (1.0 + t * (0.99229 + 0.04481 * t));
    return patches_.at(u, v) > quantile;
  }

  void drop_shadows(RangeImage& image) const {
    const std::vector<std::uint8_t> shadow = projector_shadow(clean_.image, noise_.baseline);
    for (int v = 0; v < grid_.height(); ++v) {
      for (int u = 0; u < grid_.width(); ++u) {
        if (shadow[grid_(u, v)] == 0) continue;
        const int margin = static_cast<int>(
            std::clamp(std::floor(0.5 * noise_.shadow_margin + 0.6 * growth_.at(u, v)), 0.0,
                       noise_.shadow_margin));
        for (int du = -margin; du <= margin; ++du) image.depth[grid_(u + du, v)] = 0.0f;
      }
    }
  }

  const CleanFrame& clean_;
  const SensorNoise& noise_;
  Grid grid_;
  NoiseField shift_u_, shift_v_, growth_, fine_, coarse_, slow_, patches_;
  Random random_;
  std::vector<float> depth_;
  std::vector<std::uint8_t> edges_;
};

}  // namespace

RangeImage add_sensor_noise(const CleanFrame& clean, const SensorNoise& noise, Seed seed) {
  return Sensor(clean, noise, seed).measure();
}

std::vector<std::uint8_t> projector_shadow(const RangeImage& clean, double baseline) {
  std::vector<std::uint8_t> shadow(clean.depth.size(), 0);
  if (!(baseline > 0.0)) return shadow;
  const Grid grid(clean.intrinsics);
  const double fb = clean.intrinsics.fx * baseline;
  for (int v = 0; v < grid.height(); ++v) {
    double leftmost = std::numeric_limits<double>::infinity();
    for (int u = grid.width() - 1; u >= 0; --u) {
      const double z = clean.at(u, v);
      if (!(z > 0.0)) continue;
      const double in_projector = u - fb / z;
      if (in_projector > leftmost + 1.0) shadow[grid(u, v)] = 1;
      leftmost = std::min(leftmost, in_projector);
    }
  }
  return shadow;
}

}  // namespace binpick::testing
