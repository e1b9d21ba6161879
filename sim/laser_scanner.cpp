#include "sim/laser_scanner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace binpick {
namespace {

class Scan {
 public:
  Scan(RangeImage& image, const LaserScannerOptions& options, Seed seed)
      : width_(image.intrinsics.width),
        height_(image.intrinsics.height),
        focal_(image.intrinsics.fy),
        options_(options),
        edge_stream_(derive_seed(seed, "edges")),
        noise_stream_(derive_seed(seed, "noise")),
        clean_(image.depth),
        z_(image.depth) {}

  void run() {
    spoil_edges();
    if (options_.grazing_limit_deg < 90.0) drop_grazing();
    if (options_.laser_shadow) cast_shadow();
    add_noise();
  }

 private:
  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }
  /// The draws of one point: every point owns its part of the stream.
  [[nodiscard]] static Random draws(Seed stream, std::size_t point) {
    return Random(stream, 4 * std::uint64_t{point});
  }
  [[nodiscard]] bool is_step(float a, float b) const {
    return std::abs(a - b) > static_cast<float>(options_.edge_threshold) * std::min(a, b);
  }

  /// The stripe falls on both sides of a step: its image has two peaks, or one between them.
  void spoil_edges() {
    for (int v = 1; v + 1 < height_; ++v) {
      for (int u = 1; u + 1 < width_; ++u) {
        const float here = clean_[at(u, v)];
        float other = here;
        for (const std::size_t next : {at(u - 1, v), at(u + 1, v), at(u, v - 1), at(u, v + 1)}) {
          if (is_step(here, clean_[next])) other = clean_[next];
        }
        if (other == here) continue;
        Random draw = draws(edge_stream_, at(u, v));
        const double kind = draw.uniform();
        const auto part = static_cast<float>(draw.uniform());
        if (kind < options_.edge_dropout) {
          z_[at(u, v)] = 0.0f;
        } else if (kind < options_.edge_dropout + options_.mixed_points && other > 0.0f) {
          z_[at(u, v)] = here + part * (other - here);
        }
      }
    }
  }

  /// Where the line of sight grazes a surface, its depth changes by more than z tan(limit) / f from
  /// point to point; a step between two surfaces has one small side and stays.
  void drop_grazing() {
    const double limit = std::tan(options_.grazing_limit_deg * std::numbers::pi / 180.0) / focal_;
    for (int v = 1; v + 1 < height_; ++v) {
      for (int u = 1; u + 1 < width_; ++u) {
        const float here = clean_[at(u, v)];
        const float across =
            std::min(std::abs(here - clean_[at(u - 1, v)]), std::abs(clean_[at(u + 1, v)] - here));
        const float along =
            std::min(std::abs(here - clean_[at(u, v - 1)]), std::abs(clean_[at(u, v + 1)] - here));
        if (std::hypot(across, along) > static_cast<float>(limit) * here) z_[at(u, v)] = 0.0f;
      }
    }
  }

  /// The laser lies below the camera: it lights the point of row v at its own row v - f b / z.
  /// Where a surface further down is lit at a smaller row, it stands in the light.
  void cast_shadow() {
    const auto focal_baseline = static_cast<float>(focal_ * options_.baseline);
    for (int u = 0; u < width_; ++u) {
      float lit_from = std::numeric_limits<float>::infinity();
      for (int v = height_ - 1; v >= 0; --v) {
        const float depth = clean_[at(u, v)];
        if (depth <= 0.0f) continue;
        const float row = static_cast<float>(v) - focal_baseline / depth;
        // A slope is not a shadow: half a row is left for rounding.
        if (row > lit_from + 0.5f) z_[at(u, v)] = 0.0f;
        lit_from = std::min(lit_from, row);
      }
    }
  }

  void add_noise() {
    if (options_.axial_noise <= 0.0) return;
    for (std::size_t i = 0; i < z_.size(); ++i) {
      if (z_[i] <= 0.0f) continue;
      const double sigma = options_.axial_noise * double{z_[i]} * double{z_[i]};
      z_[i] += static_cast<float>(sigma * draws(noise_stream_, i).normal());
    }
  }

  int width_;
  int height_;
  double focal_;
  const LaserScannerOptions& options_;
  Seed edge_stream_;
  Seed noise_stream_;
  std::vector<float> clean_;
  std::vector<float>& z_;
};

}  // namespace

void apply_laser_scanner(RangeImage& image, const LaserScannerOptions& options, Seed seed) {
  Scan(image, options, seed).run();
}

}  // namespace binpick
