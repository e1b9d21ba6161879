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
  std::vector<std::uint8_t> jumps(static_cast<std::size_t>(size.width));
  // jumps[u] says whether here[u] and there[u] are apart; the loop has no branch.
  const auto compare = [&](const float* here, const float* there, int count) {
    std::uint8_t any = 0;
    for (int u = 0; u < count; ++u) {
      const float nearer = std::min(here[u], there[u]);
      const std::uint8_t jump = std::abs(here[u] - there[u]) > threshold * nearer ? 1 : 0;
      jumps[static_cast<std::size_t>(u)] = jump;
      any = static_cast<std::uint8_t>(any | jump);
    }
    return any != 0;
  };
  for (int v = 0; v < size.height; ++v) {
    const float* row = z.data() + size.at(0, v);
    if (compare(row, row + 1, size.width - 1)) {
      for (int u = 0; u + 1 < size.width; ++u) {
        if (jumps[static_cast<std::size_t>(u)] == 0) continue;
        const int first = std::max(0, u + 1 - reach);
        const int last = std::min(size.width - 1, u + reach);
        std::fill_n(edges.data() + size.at(first, v), last - first + 1, std::uint8_t{1});
      }
    }
    if (v + 1 < size.height && compare(row, row + size.width, size.width)) {
      for (int u = 0; u < size.width; ++u) {
        if (jumps[static_cast<std::size_t>(u)] == 0) continue;
        const int last = std::min(size.height - 1, v + reach);
        for (int w = std::max(0, v + 1 - reach); w <= last; ++w) edges[size.at(u, w)] = 1;
      }
    }
  }
  return edges;
}

// Silhouettes follow the correlation window, not the object: near an edge, patches of 2 x 2 pixels
// take their depth from a neighbour up to `raggedness` away, and some return nothing.
void roughen_edges(std::vector<float>& z, const std::vector<float>& clean, Size size,
                   const StructuredLightOptions& options, Seed seed) {
  const int reach = static_cast<int>(std::ceil(options.edge_raggedness));
  const std::vector<std::uint8_t> edges =
      find_edges(clean, size, static_cast<float>(options.edge_threshold), std::max(1, reach));
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
  std::vector<float> columns(static_cast<std::size_t>(size.width));
  for (int v = 0; v < size.height; ++v) {
    const float* row = clean.data() + size.at(0, v);
    float* out = z.data() + size.at(0, v);
    for (int u = 0; u < size.width; ++u) {
      columns[static_cast<std::size_t>(u)] = static_cast<float>(u) - focal_baseline / row[u];
    }
    float lit_from = std::numeric_limits<float>::infinity();
    for (int u = size.width - 1; u >= 0; --u) {
      if (row[u] <= 0.0f) continue;
      const float column = columns[static_cast<std::size_t>(u)];
      // A slope is not a shadow: leave half a pixel for rounding.
      if (column > lit_from + 0.5f) out[u] = 0.0f;
      lit_from = std::min(lit_from, column);
    }
  }
}

// Noise with the given grain: normal values on a coarse grid, interpolated bilinearly and scaled
// back to the stated deviation. Neighbouring pixels share a correlation window, hence the grain.
class GrainyNoise {
 public:
  GrainyNoise(Size size, double grain, float sigma, Seed seed)
      : grain_(static_cast<float>(std::max(1.0, grain))),
        sigma_(sigma),
        nodes_(static_cast<std::size_t>(static_cast<float>(size.width) / grain_) + 2),
        values_(static_cast<std::size_t>(size.width)),
        seed_(seed) {
    for (int u = 0; u < size.width; ++u) cells_.push_back(cell_at(u));
  }

  /// The noise of image row v.
  const std::vector<float>& row(int v) {
    const Cell across = cell_at(v);
    for (std::size_t c = 0; c < nodes_.size(); ++c) {
      nodes_[c] = sigma_ * (across.before * node(across.index, c) +
                            across.after * node(across.index + 1, c));
    }
    for (std::size_t u = 0; u < values_.size(); ++u) {
      const Cell& cell = cells_[u];
      values_[u] = cell.before * nodes_[cell.index] + cell.after * nodes_[cell.index + 1];
    }
    return values_;
  }

 private:
  /// Between nodes `index` and `index` + 1, with weights that keep the variance.
  struct Cell {
    std::size_t index;
    float before;
    float after;
  };

  [[nodiscard]] Cell cell_at(int pixel) const noexcept {
    const float position = static_cast<float>(pixel) / grain_;
    const auto index = static_cast<std::size_t>(position);
    const float part = position - static_cast<float>(index);
    const float norm = 1.0f / std::sqrt(part * part + (1.0f - part) * (1.0f - part));
    return {index, norm * (1.0f - part), norm * part};
  }
  [[nodiscard]] float node(std::size_t row, std::size_t column) const noexcept {
    return roughly_normal(hash(seed_, row * 65536u + column));
  }

  float grain_;
  float sigma_;
  std::vector<Cell> cells_;
  std::vector<float> nodes_;
  std::vector<float> values_;
  Seed seed_;
};

// Depth is measured as disparity d = f b / z: an error of sigma z^2 in depth is the same error
// sigma f b of disparity everywhere. Whatever is out of range is lost.
void measure_disparity(std::vector<float>& z, Size size, const StructuredLightOptions& options,
                       float focal_baseline, Seed seed) {
  const double step = options.disparity_step;
  const double total = options.axial_noise * double{focal_baseline};
  // The stated noise includes what rounding adds: a uniform error of one step.
  const double own = std::sqrt(std::max(0.0, total * total - step * step / 12.0));
  const auto grid = static_cast<float>(step);
  const auto per_step = static_cast<float>(step > 0.0 ? 1.0 / step : 0.0);
  const auto nearest = static_cast<float>(options.min_range);
  const auto furthest = static_cast<float>(options.max_range);
  GrainyNoise noise(size, options.noise_grain, static_cast<float>(own), seed);
  for (int v = 0; v < size.height; ++v) {
    const float* error = noise.row(v).data();
    float* row = z.data() + size.at(0, v);
    for (int u = 0; u < size.width; ++u) {
      const float measured = focal_baseline / std::max(row[u], 1e-3f) + error[u];
      // Disparities are positive: truncation rounds.
      const float rounded = grid * static_cast<float>(static_cast<int>(measured * per_step + 0.5f));
      const float depth = focal_baseline / (grid > 0.0f ? rounded : measured);
      row[u] = row[u] > 0.0f && depth >= nearest && depth <= furthest ? depth : 0.0f;
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
    roughen_edges(image.depth, clean, size, options, derive_seed(seed, "edges"));
  }
  if (options.grazing_limit_deg < 90.0) {
    drop_grazing(image.depth, clean, size, image.intrinsics.fx, options.grazing_limit_deg);
  }
  if (options.projector_shadow) {
    cast_projector_shadow(image.depth, clean, size, focal_baseline);
  }
  if (options.bow != 0.0) bend(image.depth, size, options.bow);
  measure_disparity(image.depth, size, options, focal_baseline, derive_seed(seed, "disparity"));
}

}  // namespace binpick
