#include "experiments/table_comparison.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

/// x ln(x / y) with its limit at x = 0.
double x_log_ratio(double x, double y) { return x == 0.0 ? 0.0 : x * std::log(x / y); }

double smoothed_rate(const Proportion& cell) {
  return (static_cast<double>(cell.successes) + 0.5) / (static_cast<double>(cell.trials) + 1.0);
}

double deviance_of(const Proportion& counts, double rate) {
  const auto x = static_cast<double>(counts.successes);
  const auto m = static_cast<double>(counts.trials);
  return 2.0 * (x_log_ratio(x, m * rate) + x_log_ratio(m - x, m * (1.0 - rate)));
}

double log_likelihood(const Proportion& counts, double rate) {
  const auto x = static_cast<double>(counts.successes);
  const auto m = static_cast<double>(counts.trials);
  const double of_successes = x == 0.0 ? 0.0 : x * std::log(rate);
  const double of_failures = x == m ? 0.0 : (m - x) * std::log1p(-rate);
  return of_successes + of_failures;
}

/// Gamma(shape, 1) after Marsaglia and Tsang (2000); a shape below 1 is boosted.
double draw_gamma(double shape, Random& random) {
  if (shape < 1.0) {
    const double boost = std::pow(1.0 - random.uniform(), 1.0 / shape);
    return draw_gamma(shape + 1.0, random) * boost;
  }
  const double d = shape - 1.0 / 3.0;
  const double c = 1.0 / std::sqrt(9.0 * d);
  while (true) {
    const double x = random.normal();
    const double v = std::pow(1.0 + c * x, 3);
    const double u = 1.0 - random.uniform();
    if (v > 0.0 && std::log(u) < 0.5 * x * x + d - d * v + d * std::log(v)) return d * v;
  }
}

double draw_beta(double a, double b, Random& random) {
  const double x = draw_gamma(a, random);
  const double y = draw_gamma(b, random);
  return x / (x + y);
}

std::int64_t draw_binomial(std::int64_t trials, double rate, Random& random) {
  std::int64_t successes = 0;
  for (std::int64_t i = 0; i < trials; ++i) successes += random.uniform() < rate ? 1 : 0;
  return successes;
}

double bootstrap_p(const std::vector<Proportion>& ours, const std::vector<Proportion>& paper,
                   double observed, Seed seed, int draws) {
  int at_least = 0;
  for (int draw = 0; draw < draws; ++draw) {
    Random random(derive_seed(seed, static_cast<std::uint64_t>(draw)));
    double deviance = 0.0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const auto k = static_cast<double>(ours[i].successes);
      const auto n = static_cast<double>(ours[i].trials);
      const double rate = draw_beta(k + 0.5, n - k + 0.5, random);
      const Proportion counts{draw_binomial(paper[i].trials, rate, random), paper[i].trials};
      deviance += deviance_of(counts, smoothed_rate(ours[i]));
    }
    if (deviance >= observed) ++at_least;
  }
  return (at_least + 1.0) / (draws + 1.0);
}

Proportion pool(const std::vector<Proportion>& cells) {
  Proportion pooled;
  for (const Proportion& cell : cells) {
    pooled.successes += cell.successes;
    pooled.trials += cell.trials;
  }
  return pooled;
}

}  // namespace

HomogeneityTest test_homogeneity(const std::vector<Proportion>& cells) {
  const Proportion pooled = pool(cells);
  const auto used = std::count_if(cells.begin(), cells.end(),
                                  [](const Proportion& cell) { return cell.trials > 0; });
  HomogeneityTest test;
  test.degrees_of_freedom = static_cast<int>(used) - 1;
  const double rate = pooled.rate();
  if (used < 2 || rate == 0.0 || rate == 1.0) return test;
  for (const Proportion& cell : cells) {
    if (cell.trials == 0) continue;
    const auto n = static_cast<double>(cell.trials);
    const double excess = static_cast<double>(cell.successes) - n * rate;
    test.chi_square += excess * excess / (n * rate * (1.0 - rate));
  }
  test.p = regularized_upper_gamma(0.5 * test.degrees_of_freedom, 0.5 * test.chi_square);
  return test;
}

TableComparison compare_tables(const std::vector<Proportion>& ours,
                               const std::vector<Proportion>& paper, Seed seed, int draws) {
  TableComparison comparison;
  comparison.flat_rate = pool(paper).rate();
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const double flat = log_likelihood(paper[i], comparison.flat_rate);
    comparison.deviance += deviance_of(paper[i], smoothed_rate(ours[i]));
    comparison.gain_over_flat += log_likelihood(paper[i], smoothed_rate(ours[i])) - flat;
    comparison.highest_gain += log_likelihood(paper[i], paper[i].rate()) - flat;
  }
  comparison.bootstrap_p = bootstrap_p(ours, paper, comparison.deviance, seed, draws);
  return comparison;
}

FlatReference flat_reference(const std::vector<Proportion>& ours,
                             const std::vector<Proportion>& paper, Seed seed, int worlds) {
  constexpr int kDraws = 200;  // per world: the flat world's p value is far from the limit
  const double rate = pool(paper).rate();
  FlatReference reference;
  std::vector<double> gains;
  for (int world = 0; world < worlds; ++world) {
    const Seed own = derive_seed(seed, static_cast<std::uint64_t>(world));
    Random random(derive_seed(own, "flat world"));
    std::vector<Proportion> flat;
    for (const Proportion& cell : ours) {
      flat.push_back({draw_binomial(cell.trials, rate, random), cell.trials});
    }
    const TableComparison comparison = compare_tables(flat, paper, own, kDraws);
    reference.compatible_share += comparison.bootstrap_p > 0.05 ? 1.0 / worlds : 0.0;
    reference.better_share += comparison.gain_over_flat > 0.0 ? 1.0 / worlds : 0.0;
    gains.push_back(comparison.gain_over_flat);
  }
  std::sort(gains.begin(), gains.end());
  const auto at = [&](double share) {
    return gains[static_cast<std::size_t>(share * static_cast<double>(worlds - 1))];
  };
  reference.gain = {at(0.05), at(0.95)};
  return reference;
}

}  // namespace binpick
