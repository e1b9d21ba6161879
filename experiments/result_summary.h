#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/proportions.h"
#include "experiments/result_store.h"
#include "experiments/table_comparison.h"

namespace binpick {

/// The trials of one cell by number, and whether each succeeded.
using CellTrials = std::map<std::int64_t, bool>;

/// A rate over several cells. Trials of one number share what they draw: the interval takes them as
/// clusters.
struct PooledRate {
  Proportion counts;
  Interval interval{0.0, 1.0};  ///< 95 %, clustered_interval()
};

struct CellSummary {
  Proportion ours;
  Interval interval;  ///< 95 %: Wilson's or, under a stopping rule, the rule's
  std::optional<Proportion> paper;
  /// Fisher's exact test of equal rates, ours against the paper's.
  std::optional<double> paper_p;
};

/// How often trials ended in one way at one stage.
struct OutcomeCount {
  TrialOutcome outcome = TrialOutcome::kSuccess;
  TrialStage stage = TrialStage::kJudge;
  std::int64_t count = 0;
};

struct GateResult {
  std::string cell;  ///< what it is about, for a person
  double minimum_rate = 0.0;
  Proportion ours;
  Interval interval;
  bool passed = true;
};

/// The cells that share a value of the column axis, taken as one table beside the paper's.
struct ColumnSummary {
  std::string label;               ///< empty without a column axis
  std::vector<std::size_t> cells;  ///< indices, in table order
  PooledRate pooled;
  HomogeneityTest homogeneity;
  std::optional<TableComparison> comparison;  ///< when the paper has counts for all cells
  std::optional<FlatReference> flat;          ///< likewise
};

/// Two columns, or two runs, compared trial by trial under common random numbers (McNemar).
struct PairedComparison {
  std::string first;
  std::string second;
  std::int64_t only_first = 0;   ///< succeeded in the first column alone
  std::int64_t only_second = 0;  ///< in the second alone
  double p = 1.0;
};

/// Everything that is said about a run's results; a pure function of them.
struct ResultSummary {
  std::vector<CellSummary> cells;  ///< by cell index
  std::vector<ColumnSummary> columns;
  std::vector<PairedComparison> pairs;
  std::vector<OutcomeCount> outcomes;  ///< by outcome, then stage; zero counts left out
  std::vector<GateResult> gates;
  std::vector<CellTrials> trials;  ///< by cell index
  PooledRate pooled;
  std::int64_t expected_trials = 0;  ///< see TrialQuota::expected

  [[nodiscard]] PooledRate pooled_over(const std::vector<std::size_t>& cell_indices) const;
  [[nodiscard]] bool complete() const { return pooled.counts.trials == expected_trials; }
  [[nodiscard]] bool gates_passed() const;
  /// Whether there is a paper's count for any cell.
  [[nodiscard]] bool has_paper() const;
};

/// The trials of `table` that belong to the experiment; see TrialQuota.
[[nodiscard]] TrialTable trials_of(const Experiment& experiment, const TrialTable& table);

[[nodiscard]] ResultSummary summarize(const Experiment& experiment, const TrialTable& table);

/// Two robots on the same tasks: trials of the same number in the same cells of two runs, one
/// comparison per cell and, where there are several, one over all. `first` and `second` of each are
/// the cell's key.
/// @throws InputError unless both runs are of one experiment name, seed and set of cells.
[[nodiscard]] std::vector<PairedComparison> compare_runs(const Experiment& first,
                                                         const TrialTable& first_trials,
                                                         const Experiment& second,
                                                         const TrialTable& second_trials);

/// The axis whose values are printed side by side, if any.
[[nodiscard]] std::optional<std::size_t> column_axis(const ExperimentConfig& config);

}  // namespace binpick
