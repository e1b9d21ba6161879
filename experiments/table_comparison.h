#pragma once

#include <vector>

#include "experiments/proportions.h"
#include "models/random.h"

namespace binpick {

/// Pearson's chi-square test of equal rates in all cells.
struct HomogeneityTest {
  double chi_square = 0.0;
  int degrees_of_freedom = 0;
  double p = 1.0;
};

/// Cells without trials do not count. When all trials agree there is nothing to tell apart: p = 1.
[[nodiscard]] HomogeneityTest test_homogeneity(const std::vector<Proportion>& cells);

/// What the paper's counts say about simulated rates, and how little they can say.
struct TableComparison {
  /// 2 sum(x ln(x / (m p)) + (m - x) ln((m - x) / (m (1 - p)))) of the paper's counts x of m, given
  /// the simulated rates p = (k + 1/2) / (n + 1).
  double deviance = 0.0;
  /// Probability of such a deviance when the paper's counts were drawn from our world: parametric
  /// bootstrap over p ~ Beta(k + 1/2, n - k + 1/2), x ~ Bin(m, p). Compatible when above 0.05.
  double bootstrap_p = 1.0;
  /// Log-likelihood of the paper's counts under our rates, minus that under one flat rate (the
  /// paper's pooled one). Above 0: better than "all cells are equal".
  double gain_over_flat = 0.0;
  /// The same for the paper's own rates: nobody can gain more.
  double highest_gain = 0.0;
  double flat_rate = 0.0;
};

/// Compares cell by cell; both tables have the same length and every cell has trials.
/// Deterministic in `seed`; time proportional to draws x (cells + the paper's trials).
[[nodiscard]] TableComparison compare_tables(const std::vector<Proportion>& ours,
                                             const std::vector<Proportion>& paper, Seed seed,
                                             int draws = 20'000);

/// What becomes of the comparison when the truth is one flat rate, the paper's pooled one, in all
/// cells: a check that such a world passes as well says little.
struct FlatReference {
  double compatible_share = 0.0;  ///< of flat worlds with bootstrap_p above 0.05
  double better_share = 0.0;      ///< of flat worlds with gain_over_flat above 0
  Interval gain;                  ///< the middle 90 % of their gain_over_flat
};

/// Simulates `worlds` flat worlds of `ours`' numbers of trials and compares each with the paper.
[[nodiscard]] FlatReference flat_reference(const std::vector<Proportion>& ours,
                                           const std::vector<Proportion>& paper, Seed seed,
                                           int worlds = 100);

}  // namespace binpick
