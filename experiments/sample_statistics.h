#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "models/geometry.h"
#include "models/random.h"

namespace binpick {

/// A quantile of a sample and its 95 % interval from order statistics (normal approximation of the
/// rank).
struct QuantileEstimate {
  double value = 0.0;
  Interval interval;
};
/// The value below which `share` of the values lie; zeros when there are none. `share` in [0, 1].
[[nodiscard]] QuantileEstimate estimate_quantile(std::vector<double> values, double share);

/// Byar's approximation of the exact 95 % interval of a Poisson mean of which `count` were seen
/// (Breslow & Day 1987, eq. 2.13).
[[nodiscard]] Interval poisson_interval(double count);

/// The least-squares line through points, and the share of the variance of y that it explains.
struct LinearFit {
  double intercept = 0.0;
  double slope = 0.0;
  double r_squared = 0.0;
};
/// Needs two points of different x at least; else all zeros. `x` and `y` are equally long.
[[nodiscard]] LinearFit fit_line(std::span<const double> x, std::span<const double> y);

/// Ratio of the medians of paired samples and its 95 % interval from 2000 resamples of the pairs.
struct RatioEstimate {
  double value = 0.0;
  Interval interval;
};
[[nodiscard]] RatioEstimate median_ratio(std::span<const double> numerator,
                                         std::span<const double> denominator, Seed seed);

}  // namespace binpick
