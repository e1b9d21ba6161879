#pragma once

#include <cstdint>
#include <vector>

#include "models/geometry.h"

namespace binpick {

/// `successes` out of `trials` independent trials.
struct Proportion {
  std::int64_t successes = 0;
  std::int64_t trials = 0;

  [[nodiscard]] double rate() const {
    return trials == 0 ? 0.0 : static_cast<double>(successes) / static_cast<double>(trials);
  }
};

/// The trials of both.
[[nodiscard]] Proportion operator+(const Proportion& a, const Proportion& b);

/// Wilson's score interval at 95 % (Wilson 1927); [0, 1] without trials.
[[nodiscard]] Interval wilson_interval(const Proportion& proportion);

/// The 95 % interval of the rate over clusters of trials that share what they draw: Wilson's for as
/// many trials as would say the same if they were independent, the trials over the design effect
/// (Korn and Graubard, Survey Methodology 24, 1998), and never for more than there are. Where all
/// succeed or all fail there is no variance to tell: then for as many as there are clusters.
[[nodiscard]] Interval clustered_interval(const std::vector<Proportion>& clusters);

/// The exact interval of Clopper and Pearson (1934) at 95 %; covers at least 95 % always.
[[nodiscard]] Interval clopper_pearson_interval(const Proportion& proportion);

/// The interval of Agresti and Coull (1998): Wald's after `z`^2 / 2 more successes and as many more
/// failures. A closed form that errs towards covering near 0 and 1. `z` is the normal
/// distribution's critical value.
[[nodiscard]] Interval agresti_coull_interval(const Proportion& proportion, double z);

/// Fisher's exact test of equal rates, two-sided: the probability of tables that are not more
/// likely than this one, margins fixed.
[[nodiscard]] double fisher_exact_p(const Proportion& a, const Proportion& b);

/// McNemar's exact test for paired trials, two-sided: `only_a` pairs succeeded under the first
/// condition alone, `only_b` under the second alone.
[[nodiscard]] double mcnemar_exact_p(std::int64_t only_a, std::int64_t only_b);

/// I_x(a, b), the regularised incomplete beta function; a, b > 0. Relative error below 1e-12 for
/// a, b up to 1e5 (continued fraction, modified Lentz).
[[nodiscard]] double regularized_incomplete_beta(double a, double b, double x);

/// Q(a, x) = 1 - P(a, x), the regularised upper incomplete gamma function; a > 0, x >= 0.
[[nodiscard]] double regularized_upper_gamma(double a, double x);

}  // namespace binpick
