#include "sim/structured_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace binpick {
namespace {

// One Philox call per pixel would cost more than the whole model; the finaliser of SplitMix64
// (Steele et al., OOPSLA 2014) over a counter is enough for noise that is only looked at.
std::uint64_t hash(std::uint64_t key, std::uint64_t counter) noexcept {
  std::uint64_t z = key + counter * 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

// Sum of four uniforms of 16 bits, scaled to unit variance: normal enough up to three sigma.
float roughly_normal(std::uint64_t bits) noexcept {
  const auto sum = static_cast<float>((bits & 0xffff) + ((bits >> 16) & 0xffff) +
                                      ((bits >> 32) & 0xffff) + (bits >> 48));
  return (sum / 65536.0f - 2.0f) * 1.7320508f;
}

struct Size {
  int width;
  int height;
  [[nodiscard]] std::size_t at(int u, int v) const noexcept {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(u);
  }
};

// Marks every pixel within `reach` of a relative depth step above `threshold` along its row or
// column.
std::vector<std::uint8_t> find_edges(const std::vector<float>& z, Size size, float threshold,
                                     int reach) {
  std::vector<std::uint8_t> edges(z.size(), 0);
  const auto jump = [&](std::size_t a, std::size_t b) {
    return std::abs(z[a] - z[b]) > threshold * std::min(z[a], z[b]);
  };
  for (int v = 0; v < size.height; ++v) {
    const std::size_t row = size.at(0, v);
    for (int u = 0; u + 1 < size.width; ++u) {
      const std::size_t i = row + static_cast<std::size_t>(u);
      if (!jump(i, i + 1)) continue;
      const int first = std::max(0, u + 1 - reach);
      const int last = std::min(size.width - 1, u + reach);
      std::fill(edges.begin() + static_cast<std::ptrdiff_t>(size.at(first, v)),
                edges.begin() + static_cast<std::ptrdiff_t>(size.at(last, v)) + 1, std::uint8_t{1});
    }
  }
  for (int v = 0; v + 1 < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      if (!jump(size.at(u, v), size.at(u, v + 1))) continue;
      for (int w = std::max(0, v + 1 - reach); w <= std::min(size.height - 1, v + reach); ++w) {
        edges[size.at(u, w)] = 1;
      }
    }
  }
  return edges;
}

// Silhouettes follow the correlation window, not the object: near an edge, patches of 2 x 2 pixels
// take their depth from a neighbour up to `raggedness` away, and some return nothing.
void roughen_edges(std::vector<float>& z, Size size, const StructuredLightOptions& options,
                   Seed seed) {
  const int reach = static_cast<int>(std::ceil(options.edge_raggedness));
  const std::vector<std::uint8_t> edges =
      find_edges(z, size, static_cast<float>(options.edge_threshold), std::max(1, reach));
  const std::vector<float> clean = z;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const std::size_t i = size.at(u, v);
      if (edges[i] == 0) continue;
      const std::uint64_t bits = hash(seed, size.at(u / 2, v / 2));
      const auto shift = [&](int byte) {
        const double unit = static_cast<double>((bits >> (16 * byte)) & 0xffff) / 65535.0;
        return static_cast<int>(std::lround((2.0 * unit - 1.0) * options.edge_raggedness));
      };
      const int from_u = std::clamp(u + shift(0), 0, size.width - 1);
      const int from_v = std::clamp(v + shift(1), 0, size.height - 1);
      const bool lost = static_cast<double>(bits >> 48) < options.edge_dropout * 65536.0;
      z[i] = lost ? 0.0f : clean[size.at(from_u, from_v)];
    }
  }
}

float smaller_step(float before, float here, float after) noexcept {
  return std::min(std::abs(here - before), std::abs(after - here));
}

// A surface that the line of sight grazes scatters the pattern away: there the depth changes by
// more than z tan(angle) / f per pixel. A step between two surfaces has one small side and stays.
void drop_grazing(std::vector<float>& z, const std::vector<float>& clean, Size size, double focal,
                  double limit_deg) {
  const auto slope_limit = static_cast<float>(std::tan(limit_deg * M_PI / 180.0) / focal);
  for (int v = 1; v + 1 < size.height; ++v) {
    const float* above = clean.data() + size.at(0, v - 1);
    const float* row = clean.data() + size.at(0, v);
    const float* below = clean.data() + size.at(0, v + 1);
    float* out = z.data() + size.at(0, v);
    for (int u = 1; u + 1 < size.width; ++u) {
      const float du = smaller_step(row[u - 1], row[u], row[u + 1]);
      const float dv = smaller_step(above[u], row[u], below[u]);
      const float limit = slope_limit * row[u];
      out[u] = du * du + dv * dv > limit * limit ? 0.0f : out[u];
    }
  }
}

// The projector stands `baseline` to the right: it lights the point of pixel u at its own column
// u - f b / z. Where a surface further right is lit at a smaller column, it stands in the light.
void cast_projector_shadow(std::vector<float>& z, const std::vector<float>& clean, Size size,
                           float focal_baseline) {
  for (int v = 0; v < size.height; ++v) {
    float lit_from = std::numeric_limits<float>::infinity();
    for (int u = size.width - 1; u >= 0; --u) {
      const std::size_t i = size.at(u, v);
      if (clean[i] <= 0.0f) continue;
      const float column = static_cast<float>(u) - focal_baseline / clean[i];
      // A slope is not a shadow: leave half a pixel for rounding.
      if (column > lit_from + 0.5f) z[i] = 0.0f;
      lit_from = std::min(lit_from, column);
    }
  }
}

// Noise with the given grain: normal values on a coarse grid, interpolated bilinearly and scaled
// back to unit variance. Neighbouring pixels share a correlation window, hence the grain.
class GrainyNoise {
 public:
  GrainyNoise(Size size, double grain, Seed seed)
      : grain_(static_cast<float>(std::max(1.0, grain))),
        columns_(static_cast<int>(static_cast<float>(size.width) / grain_) + 2),
        weights_(static_cast<std::size_t>(size.width)),
        cells_(static_cast<std::size_t>(size.width)),
        row_(static_cast<std::size_t>(columns_)),
        seed_(seed) {
    for (int u = 0; u < size.width; ++u) {
      const float position = static_cast<float>(u) / grain_;
      cells_[static_cast<std::size_t>(u)] = static_cast<int>(position);
      weights_[static_cast<std::size_t>(u)] = position - std::floor(position);
    }
  }

  /// Enters image row v.
  void set_row(int v) {
    const float position = static_cast<float>(v) / grain_;
    const int upper = static_cast<int>(position);
    const float part = position - static_cast<float>(upper);
    const float scale = norm(part);
    for (int c = 0; c < columns_; ++c) {
      row_[static_cast<std::size_t>(c)] =
          scale * ((1.0f - part) * node(upper, c) + part * node(upper + 1, c));
    }
  }

  [[nodiscard]] float at(int u) const noexcept {
    const auto i = static_cast<std::size_t>(u);
    const auto cell = static_cast<std::size_t>(cells_[i]);
    const float part = weights_[i];
    return norm(part) * ((1.0f - part) * row_[cell] + part * row_[cell + 1]);
  }

 private:
  static float norm(float part) noexcept {
    return 1.0f / std::sqrt(part * part + (1.0f - part) * (1.0f - part));
  }
  [[nodiscard]] float node(int row, int column) const noexcept {
    const auto index =
        static_cast<std::uint64_t>(row) * 65536u + static_cast<std::uint64_t>(column);
    return roughly_normal(hash(seed_, index));
  }

  float grain_;
  int columns_;
  std::vector<float> weights_;
  std::vector<int> cells_;
  std::vector<float> row_;
  Seed seed_;
};

// Depth is measured as disparity d = f b / z: an error of sigma z^2 in depth is the same error
// sigma f b of disparity everywhere.
void measure_disparity(std::vector<float>& z, Size size, const StructuredLightOptions& options,
                       float focal_baseline, Seed seed) {
  const double step = options.disparity_step;
  const double total = options.axial_noise * double{focal_baseline};
  // The stated noise includes what rounding adds: a uniform error of one step.
  const double own = std::sqrt(std::max(0.0, total * total - step * step / 12.0));
  const auto sigma = static_cast<float>(own);
  const auto grid = static_cast<float>(step);
  const auto per_step = static_cast<float>(step > 0.0 ? 1.0 / step : 0.0);
  GrainyNoise noise(size, options.noise_grain, seed);
  for (int v = 0; v < size.height; ++v) {
    noise.set_row(v);
    float* row = z.data() + size.at(0, v);
    for (int u = 0; u < size.width; ++u) {
      if (row[u] <= 0.0f) continue;
      float disparity = focal_baseline / row[u] + sigma * noise.at(u);
      if (step > 0.0) disparity = grid * std::floor(disparity * per_step + 0.5f);
      row[u] = disparity > 0.0f ? focal_baseline / disparity : 0.0f;
    }
  }
}

// The sensor's smooth distortion: grows with the square of the distance from the image centre.
void bend(std::vector<float>& z, Size size, double bow) {
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double x = 2.0 * u / (size.width - 1) - 1.0;
      const double y = 2.0 * v / (size.height - 1) - 1.0;
      float& depth = z[size.at(u, v)];
      depth += static_cast<float>(bow * 0.5 * (x * x + y * y)) * depth * depth;
    }
  }
}

}  // namespace

void apply_structured_light(RangeImage& image, const StructuredLightOptions& options, Seed seed) {
  if (!options.enabled) return;
  const Size size{image.intrinsics.width, image.intrinsics.height};
  const std::vector<float> clean = image.depth;
  const auto focal_baseline = static_cast<float>(image.intrinsics.fx * options.baseline);
  if (options.edge_raggedness > 0.0 || options.edge_dropout > 0.0) {
    roughen_edges(image.depth, size, options, derive_seed(seed, "edges"));
  }
  if (options.grazing_limit_deg < 90.0) {
    drop_grazing(image.depth, clean, size, image.intrinsics.fx, options.grazing_limit_deg);
  }
  if (options.projector_shadow) {
    cast_projector_shadow(image.depth, clean, size, focal_baseline);
  }
  if (options.bow != 0.0) bend(image.depth, size, options.bow);
  measure_disparity(image.depth, size, options, focal_baseline, derive_seed(seed, "disparity"));
  for (float& z : image.depth) {
    if (z < static_cast<float>(options.min_range) || z > static_cast<float>(options.max_range)) {
      z = 0.0f;
    }
  }
}

}  // namespace binpick
