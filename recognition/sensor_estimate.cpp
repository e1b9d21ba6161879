#include "recognition/sensor_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "recognition/parallel_for.h"

namespace binpick {
namespace {

constexpr std::array<int, 4> kSteps = {1, 2, 4, 8};  // pixels between the three points
constexpr std::size_t kWidest = kSteps.size() - 1;
constexpr std::size_t kFewest = 200;       // differences for a median that means something
constexpr float kSameSurface = 0.02f;      // of the depth: larger steps are silhouettes
constexpr double kNormalByMedian = 2.198;  // variance of a normal variable by its median square
constexpr int kDepthBins = 6;
constexpr float kSteep = 1.5f;  // tangent of the slant from which lateral noise counts

/// The variance of what the squares belong to, from their median.
double robust_variance(std::vector<float>& squares) {
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return kNormalByMedian * static_cast<double>(*middle);
}

/// Squares of second differences, in depth: e = z_left - 2 z + z_right after the plane is taken
/// off.
class Differences {
 public:
  Differences(const Projection& projection, const std::vector<ScenePixel>& pixels, int jobs)
      : projection_(projection), pixels_(pixels) {
    for (const ScenePixel& pixel : pixels) {
      if (!(pixel.depth > 0.0f)) continue;
      nearest_ = nearest_ > 0.0f ? std::min(nearest_, pixel.depth) : pixel.depth;
      farthest_ = std::max(farthest_, pixel.depth);
    }
    // Each of what is collected comes from one step alone.
    parallel_for(static_cast<int>(kSteps.size()), jobs,
                 [&](int step) { collect(static_cast<std::size_t>(step)); });
    std::vector<Bin*> bins = {&steep_};
    for (Bin& bin : of_step_) bins.push_back(&bin);
    for (Bin& bin : by_depth_) bins.push_back(&bin);
    parallel_for(static_cast<int>(bins.size()), jobs, [&](int i) {
      Bin& bin = *bins[static_cast<std::size_t>(i)];
      if (bin.is_enough()) bin.variance = robust_variance(bin.squares);
    });
  }

  struct Bin {
    std::vector<float> squares;
    double variance = 0.0;  // of a difference, if there are enough of them
    double depth = 0.0;     // sums
    double slant = 0.0;     // of (dz / pixel)^2

    [[nodiscard]] bool is_enough() const { return squares.size() >= kFewest; }
    [[nodiscard]] double count() const { return static_cast<double>(squares.size()); }
  };
  /// The differences of the widest step on surfaces that face the sensor.
  [[nodiscard]] const std::vector<Bin>& by_depth() const { return by_depth_; }
  [[nodiscard]] const Bin& steep() const { return steep_; }
  [[nodiscard]] const Bin& of_step(std::size_t step) const { return of_step_[step]; }

 private:
  void collect(std::size_t step) {
    const int s = kSteps[step];
    for (int v = 1; v < projection_.height; v += 2) {
      for (int u = s; u + s < projection_.width; u += 2) {
        const int index = v * projection_.width + u;
        const float z = depth(index);
        const float left = depth(index - s);
        const float right = depth(index + s);
        if (!(z > 0.0f && left > 0.0f && right > 0.0f)) continue;
        // On a plane 1 / z is linear in the image.
        const float difference = z * z * (1.0f / left + 1.0f / right - 2.0f / z);
        const float slope = (right - left) / static_cast<float>(2 * s);
        if (std::abs(difference) > kSameSurface * z) continue;
        add(step, z, difference * difference, slope);
      }
    }
  }
  void add(std::size_t step, float z, float square, float slope) {
    const float tangent = std::abs(slope) * projection_.fx / z;
    if (tangent < 0.5f * kSteep) of_step_[step].squares.push_back(square);
    if (step != kWidest && tangent < kSteep) return;
    Bin* bin = &steep_;
    if (tangent < kSteep) {
      const float place = (z - nearest_) / std::max(farthest_ - nearest_, 1e-6f);
      bin = &by_depth_[static_cast<std::size_t>(
          std::min(static_cast<int>(place * kDepthBins), kDepthBins - 1))];
    } else if (step != 1) {
      return;
    }
    bin->squares.push_back(square);
    bin->depth += static_cast<double>(z);
    bin->slant += static_cast<double>(slope * slope);
  }

  [[nodiscard]] float depth(int index) const {
    return pixels_[static_cast<std::size_t>(index)].depth;
  }

  const Projection& projection_;
  const std::vector<ScenePixel>& pixels_;
  float nearest_ = 0.0f;
  float farthest_ = 0.0f;
  std::vector<Bin> by_depth_{kDepthBins};
  Bin steep_;
  std::array<Bin, kSteps.size()> of_step_;
};

/// variance = constant^2 + quadratic^2 z^4 over the bins, both terms at least zero.
void fit_axial(const std::vector<Differences::Bin>& bins, SensorEstimate& sensor) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Differences::Bin& bin : bins) {
    const double variance = bin.variance / 6.0;  // 1 + 4 + 1
    if (!(variance > 0.0)) continue;
    const double z = bin.depth / bin.count();
    // Relative errors count, as a variance's error grows with it.
    const double weight = bin.count() / (variance * variance);
    const Eigen::Vector2d row(1.0, std::pow(z, 4));
    information += weight * row * row.transpose();
    right += weight * variance * row;
  }
  if (!(information(0, 0) > 0.0)) return;
  Eigen::Vector2d terms = Eigen::Vector2d::Zero();
  const double determinant = information.determinant();
  if (determinant > 1e-6 * information(0, 0) * information(1, 1)) {
    terms = information.inverse() * right;
  }
  // One of them alone where both together would ask for a negative one; triangulation where the
  // depths are too much alike to tell.
  if (!(terms[0] >= 0.0 && terms[1] >= 0.0) || terms.isZero()) {
    const bool is_constant = terms[1] < 0.0;
    terms = is_constant ? Eigen::Vector2d(right[0] / information(0, 0), 0.0)
                        : Eigen::Vector2d(0.0, right[1] / information(1, 1));
  }
  sensor.constant = static_cast<float>(std::sqrt(terms[0]));
  sensor.quadratic = static_cast<float>(std::sqrt(terms[1]));
}

/// From how the variance of second differences grows with the step: 6 - 8 rho(s) + 2 rho(2 s).
float correlated_pixels(const Differences& differences) {
  constexpr double kLeastCorrelation = 0.05;  // less is the medians' own noise
  std::array<double, kSteps.size() + 1> rho{};
  double plateau = 0.0;
  std::array<double, kSteps.size()> variances{};
  for (std::size_t i = 0; i < kSteps.size(); ++i) {
    if (!differences.of_step(i).is_enough()) return 1.0f;
    variances[i] = differences.of_step(i).variance;
    plateau = std::max(plateau, variances[i] / 6.0);
  }
  if (!(plateau > 0.0)) return 1.0f;
  double sum = 1.0;
  for (std::size_t i = kSteps.size(); i-- > 0;) {
    rho[i] = std::clamp((6.0 + 2.0 * rho[i + 1] - variances[i] / plateau) / 8.0, 0.0, 1.0);
    if (rho[i] < kLeastCorrelation) rho[i] = 0.0;
    // Steps double: each stands for the pixels up to the next, on both sides.
    sum += 2.0 * rho[i] * std::max(0.75 * kSteps[i], 1.0);
  }
  return static_cast<float>(sum * sum);
}

}  // namespace

SensorEstimate estimate_sensor(const Projection& projection, const std::vector<ScenePixel>& pixels,
                               int jobs) {
  constexpr float kLeastLateral = 0.1f;
  constexpr float kMostLateral = 0.5f;
  SensorEstimate sensor;
  const Differences differences(projection, pixels, jobs);
  fit_axial(differences.by_depth(), sensor);
  sensor.correlated_pixels = correlated_pixels(differences);
  sensor.lateral = kLeastLateral;
  const Differences::Bin& steep = differences.steep();
  if (steep.is_enough()) {
    const auto depth = static_cast<float>(steep.depth / steep.count());
    const double excess = steep.variance / 6.0 - static_cast<double>(sensor.axial_variance(depth));
    const double lateral = std::sqrt(std::max(excess, 0.0) / (steep.slant / steep.count()));
    sensor.lateral = std::clamp(static_cast<float>(lateral), kLeastLateral, kMostLateral);
  }
  return sensor;
}

}  // namespace binpick
