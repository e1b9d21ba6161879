#include "experiments/proportions.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binpick {
namespace {

constexpr double kNormalQuantile = 1.959963984540054;  // of 0.975
constexpr double kTail = 0.025;
constexpr double kTiny = 1e-300;
constexpr double kPrecision = 1e-15;
constexpr int kMaxIterations = 100'000;

double log_choose(std::int64_t n, std::int64_t k) {
  return std::lgamma(static_cast<double>(n) + 1.0) - std::lgamma(static_cast<double>(k) + 1.0) -
         std::lgamma(static_cast<double>(n - k) + 1.0);
}

double away_from_zero(double value) { return std::abs(value) < kTiny ? kTiny : value; }

/// The continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8).
double beta_continued_fraction(double a, double b, double x) {
  double c = 1.0;
  double d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
  double result = d;
  for (int i = 1; i < kMaxIterations; ++i) {
    const double m = i;
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    d = 1.0 / away_from_zero(1.0 + even * d);
    c = away_from_zero(1.0 + even / c);
    result *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 / away_from_zero(1.0 + odd * d);
    c = away_from_zero(1.0 + odd / c);
    result *= d * c;
    if (std::abs(d * c - 1.0) < kPrecision) break;
  }
  return result;
}

/// x with I_x(a, b) = p, by bisection to the last bits: the function is monotone.
double inverse_incomplete_beta(double a, double b, double p) {
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 200 && high - low > std::numeric_limits<double>::epsilon() * high; ++i) {
    const double middle = 0.5 * (low + high);
    (regularized_incomplete_beta(a, b, middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Wilson's interval of a rate `p` seen in `n` trials, which need not be whole.
Interval wilson_interval(double p, double n) {
  const double z2 = kNormalQuantile * kNormalQuantile;
  const double centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half =
      kNormalQuantile / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  // At the ends the bound is exact; rounding must not move it inside.
  return {p == 0.0 ? 0.0 : std::max(0.0, centre - half),
          p == 1.0 ? 1.0 : std::min(1.0, centre + half)};
}

}  // namespace

double regularized_incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  const double log_front =
      std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x);
  // The fraction converges fast on this side of the mean; the other follows by symmetry.
  if (x < (a + 1.0) / (a + b + 2.0)) {
    return std::exp(log_front) * beta_continued_fraction(a, b, x) / a;
  }
  return 1.0 - std::exp(log_front) * beta_continued_fraction(b, a, 1.0 - x) / b;
}

double regularized_upper_gamma(double a, double x) {
  if (x <= 0.0) return 1.0;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (int i = 1; i < kMaxIterations && term > sum * kPrecision; ++i) {
      term *= x / (a + i);
      sum += term;
    }
    return 1.0 - front * sum;
  }
  double b = x + 1.0 - a;
  double c = 1.0 / kTiny;
  double d = 1.0 / b;
  double result = d;
  for (int i = 1; i < kMaxIterations; ++i) {
    const double numerator = -i * (i - a);
    b += 2.0;
    d = 1.0 / away_from_zero(numerator * d + b);
    c = away_from_zero(b + numerator / c);
    result *= d * c;
    if (std::abs(d * c - 1.0) < kPrecision) break;
  }
  return front * result;
}

Proportion operator+(const Proportion& a, const Proportion& b) {
  return {a.successes + b.successes, a.trials + b.trials};
}

Interval wilson_interval(const Proportion& proportion) {
  if (proportion.trials == 0) return {0.0, 1.0};
  return wilson_interval(proportion.rate(), static_cast<double>(proportion.trials));
}

Interval clustered_interval(const std::vector<Proportion>& clusters) {
  Proportion total;
  for (const Proportion& cluster : clusters) total = total + cluster;
  const auto n = static_cast<double>(total.trials);
  const auto k = static_cast<double>(clusters.size());
  if (n <= k) return wilson_interval(total);
  const double p = total.rate();
  const double independent = p * (1.0 - p) / n;
  if (k < 2.0 || !(independent > 0.0)) return wilson_interval(p, k);
  double squares = 0.0;
  for (const Proportion& cluster : clusters) {
    const double residual =
        static_cast<double>(cluster.successes) - p * static_cast<double>(cluster.trials);
    squares += residual * residual;
  }
  const double variance = k / (k - 1.0) * squares / (n * n);
  return wilson_interval(p, n / std::max(variance / independent, 1.0));
}

Interval clopper_pearson_interval(const Proportion& proportion) {
  const auto k = static_cast<double>(proportion.successes);
  const auto n = static_cast<double>(proportion.trials);
  const double low =
      proportion.successes == 0 ? 0.0 : inverse_incomplete_beta(k, n - k + 1.0, kTail);
  const double high = proportion.successes == proportion.trials
                          ? 1.0
                          : inverse_incomplete_beta(k + 1.0, n - k, 1.0 - kTail);
  return {low, high};
}

Interval agresti_coull_interval(const Proportion& proportion, double z) {
  const double n = static_cast<double>(proportion.trials) + z * z;
  const double p = (static_cast<double>(proportion.successes) + 0.5 * z * z) / n;
  const double half = z * std::sqrt(p * (1.0 - p) / n);
  return {std::max(0.0, p - half), std::min(1.0, p + half)};
}

double fisher_exact_p(const Proportion& a, const Proportion& b) {
  const std::int64_t successes = a.successes + b.successes;
  const std::int64_t trials = a.trials + b.trials;
  const double log_all = log_choose(trials, successes);
  const auto log_probability = [&](std::int64_t k) {
    return log_choose(a.trials, k) + log_choose(b.trials, successes - k) - log_all;
  };
  // Tables as likely as the observed one count in spite of rounding.
  const double limit = log_probability(a.successes) + 1e-9;
  double p = 0.0;
  const std::int64_t first = std::max<std::int64_t>(0, successes - b.trials);
  const std::int64_t last = std::min(a.trials, successes);
  for (std::int64_t k = first; k <= last; ++k) {
    const double log_p = log_probability(k);
    if (log_p <= limit) p += std::exp(log_p);
  }
  return std::min(p, 1.0);
}

double mcnemar_exact_p(std::int64_t only_a, std::int64_t only_b) {
  const std::int64_t discordant = only_a + only_b;
  if (discordant == 0) return 1.0;
  const auto fewer = static_cast<double>(std::min(only_a, only_b));
  // P(X <= k) for X ~ Bin(n, 1/2) is I_{1/2}(n - k, k + 1).
  const double tail =
      regularized_incomplete_beta(static_cast<double>(discordant) - fewer, fewer + 1.0, 0.5);
  return std::min(1.0, 2.0 * tail);
}

}  // namespace binpick
