#include "experiments/sample_statistics.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr double kNormal95 = 1.959963984540054;
constexpr int kResamples = 2000;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace

QuantileEstimate estimate_quantile(std::vector<double> values, double share) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const double last = static_cast<double>(values.size() - 1);
  const auto at = [&](double rank) {
    const double clamped = std::clamp(rank, 0.0, last);
    const auto below = static_cast<std::size_t>(clamped);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (clamped - std::floor(clamped)) * (values[above] - values[below]);
  };
  const double rank = share * last;
  const double spread =
      kNormal95 * std::sqrt(static_cast<double>(values.size()) * share * (1.0 - share));
  return {at(rank), {at(std::floor(rank - spread)), at(std::ceil(rank + spread))}};
}

Interval poisson_interval(double count) {
  const auto bound = [](double k, double z) {
    return k <= 0.0 ? 0.0 : k * std::pow(1.0 - 1.0 / (9.0 * k) + z / (3.0 * std::sqrt(k)), 3);
  };
  // With none seen, exactly: exp(-mean) = 0.025.
  if (count <= 0.0) return {0.0, -std::log(0.025)};
  return {bound(count, -kNormal95), bound(count + 1.0, kNormal95)};
}

LinearFit fit_line(std::span<const double> x, std::span<const double> y) {
  const double n = static_cast<double>(x.size());
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / n;
    mean_y += y[i] / n;
  }
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  if (!(xx > 0.0)) return {};
  const double slope = xy / xx;
  return {mean_y - slope * mean_x, slope, yy > 0.0 ? xy * xy / (xx * yy) : 1.0};
}

RatioEstimate median_ratio(std::span<const double> numerator, std::span<const double> denominator,
                           Seed seed) {
  const std::size_t n = std::min(numerator.size(), denominator.size());
  if (n == 0) return {};
  const auto ratio = [&](auto index) {
    std::vector<double> above;
    std::vector<double> below;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t pair = index(i);
      above.push_back(numerator[pair]);
      below.push_back(denominator[pair]);
    }
    return median(std::move(above)) / median(std::move(below));
  };
  Random draw(seed);
  std::vector<double> resampled;
  for (int k = 0; k < kResamples; ++k) {
    resampled.push_back(ratio([&](std::size_t) { return std::size_t(draw.index(n)); }));
  }
  std::sort(resampled.begin(), resampled.end());
  constexpr std::size_t kTail = kResamples / 40;
  return {ratio([](std::size_t i) { return i; }),
          {resampled[kTail], resampled[kResamples - 1 - kTail]}};
}

}  // namespace binpick
