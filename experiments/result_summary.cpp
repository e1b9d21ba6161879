#include "experiments/result_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "experiments/trial_quota.h"
#include "models/errors.h"

namespace binpick {
namespace {

std::vector<CellTrials> successes_by_cell(const Experiment& experiment, const TrialTable& table) {
  std::map<std::string, std::size_t> index_of;
  for (const Cell& cell : experiment.cells()) index_of[cell.key] = cell.index;
  std::vector<CellTrials> cells(experiment.cells().size());
  for (const auto& [key, trial] : table) {
    cells[index_of.at(key.cell)][key.trial] = trial.record.outcome == TrialOutcome::kSuccess;
  }
  return cells;
}

Proportion proportion_of(const CellTrials& trials) {
  Proportion proportion;
  for (const auto& [trial, success] : trials) {
    ++proportion.trials;
    proportion.successes += success ? 1 : 0;
  }
  return proportion;
}

/// The paper's counts for exactly this cell: an entry that matches it and is not shared with cells
/// other than those that differ in the column axis alone.
std::optional<Proportion> paper_counts(const ExperimentConfig& config, const Cell& cell) {
  const auto column = column_axis(config);
  for (const PaperCount& paper : config.paper) {
    std::size_t named = 0;
    for (std::size_t axis = 0; axis < config.axes.size(); ++axis) {
      if (paper.cell.contains(config.axes[axis].name) || axis == column) ++named;
    }
    if (named == config.axes.size() && matches(paper.cell, config.axes, cell)) {
      return Proportion{paper.successes, paper.trials};
    }
  }
  return std::nullopt;
}

CellSummary summarize_cell(const ExperimentConfig& config, const TrialQuota& quota,
                           const Cell& cell, const CellTrials& trials) {
  CellSummary summary;
  summary.ours = proportion_of(trials);
  summary.interval = quota.interval(summary.ours);
  summary.paper = paper_counts(config, cell);
  if (summary.paper && summary.ours.trials > 0) {
    summary.paper_p = fisher_exact_p(summary.ours, *summary.paper);
  }
  return summary;
}

ColumnSummary summarize_column(const Experiment& experiment, const ResultSummary& all,
                               std::optional<std::size_t> axis, std::size_t value) {
  ColumnSummary column;
  if (axis) column.label = experiment.config().axes[*axis].label(value);
  std::vector<Proportion> ours;
  std::vector<Proportion> paper;
  for (const Cell& cell : experiment.cells()) {
    if (axis && cell.values[*axis] != value) continue;
    const CellSummary& summary = all.cells[cell.index];
    column.cells.push_back(cell.index);
    ours.push_back(summary.ours);
    if (summary.paper && summary.ours.trials > 0) paper.push_back(*summary.paper);
  }
  column.pooled = all.pooled_over(column.cells);
  column.homogeneity = test_homogeneity(ours);
  if (paper.size() == ours.size()) {
    const Seed seed = derive_seed(static_cast<Seed>(experiment.config().seed), "bootstrap");
    column.comparison = compare_tables(ours, paper, seed);
    if (ours.size() > 1) column.flat = flat_reference(ours, paper, seed);
  }
  return column;
}

/// Adds the pairs of trials of the same number in two cells; `p` is not touched.
void add_pairs(const CellTrials& first, const CellTrials& second, PairedComparison& pair) {
  for (const auto& [trial, success] : first) {
    const auto partner = second.find(trial);
    if (partner == second.end() || partner->second == success) continue;
    ++(success ? pair.only_first : pair.only_second);
  }
}

PairedComparison compare_columns(const ColumnSummary& first, const ColumnSummary& second,
                                 const std::vector<CellTrials>& trials) {
  PairedComparison pair{first.label, second.label};
  for (std::size_t row = 0; row < first.cells.size(); ++row) {
    add_pairs(trials[first.cells[row]], trials[second.cells[row]], pair);
  }
  pair.p = mcnemar_exact_p(pair.only_first, pair.only_second);
  return pair;
}

GateResult judge_gate(const Experiment& experiment, const GateConfig& gate,
                      const ResultSummary& all) {
  GateResult result;
  result.minimum_rate = gate.minimum_rate;
  for (const auto& [axis, value] : gate.cell) {
    result.cell += fmt::format("{}{}={}", result.cell.empty() ? "" : ",", axis, value);
  }
  if (result.cell.empty()) result.cell = "all cells";
  std::vector<std::size_t> cells;
  for (const Cell& cell : experiment.cells()) {
    if (matches(gate.cell, experiment.config().axes, cell)) cells.push_back(cell.index);
  }
  const PooledRate rate = all.pooled_over(cells);
  result.ours = rate.counts;
  result.interval = rate.interval;
  result.passed = result.interval.high >= gate.minimum_rate;
  return result;
}

std::vector<OutcomeCount> count_outcomes(const TrialTable& table) {
  std::map<std::pair<TrialOutcome, TrialStage>, std::int64_t> counts;
  for (const auto& [key, trial] : table) ++counts[{trial.record.outcome, trial.record.stage}];
  std::vector<OutcomeCount> result;
  for (const auto& [kind, count] : counts) result.push_back({kind.first, kind.second, count});
  return result;
}

}  // namespace

PooledRate ResultSummary::pooled_over(const std::vector<std::size_t>& cell_indices) const {
  std::map<std::int64_t, Proportion> by_number;
  for (const std::size_t cell : cell_indices) {
    for (const auto& [number, success] : trials[cell]) {
      by_number[number] = by_number[number] + Proportion{success ? 1 : 0, 1};
    }
  }
  PooledRate rate;
  std::vector<Proportion> clusters;
  clusters.reserve(by_number.size());
  for (const auto& [number, cluster] : by_number) {
    rate.counts = rate.counts + cluster;
    clusters.push_back(cluster);
  }
  rate.interval = clustered_interval(clusters);
  return rate;
}

bool ResultSummary::gates_passed() const {
  return std::all_of(gates.begin(), gates.end(),
                     [](const GateResult& gate) { return gate.passed; });
}

bool ResultSummary::has_paper() const {
  return std::any_of(cells.begin(), cells.end(),
                     [](const CellSummary& cell) { return cell.paper.has_value(); });
}

std::optional<std::size_t> column_axis(const ExperimentConfig& config) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (config.axes[i].columns) return i;
  }
  return std::nullopt;
}

TrialTable trials_of(const Experiment& experiment, const TrialTable& table) {
  return TrialQuota(experiment).select(table);
}

ResultSummary summarize(const Experiment& experiment, const TrialTable& table) {
  const TrialQuota quota(experiment);
  const TrialTable own = quota.select(table);
  const ExperimentConfig& config = experiment.config();
  ResultSummary summary;
  summary.trials = successes_by_cell(experiment, own);
  summary.expected_trials = quota.expected(own);
  std::vector<std::size_t> all_cells;
  for (const Cell& cell : experiment.cells()) {
    summary.cells.push_back(summarize_cell(config, quota, cell, summary.trials[cell.index]));
    all_cells.push_back(cell.index);
  }
  summary.pooled = summary.pooled_over(all_cells);
  const auto axis = column_axis(config);
  const std::size_t columns = axis ? config.axes[*axis].values.size() : 1;
  for (std::size_t value = 0; value < columns; ++value) {
    summary.columns.push_back(summarize_column(experiment, summary, axis, value));
  }
  for (std::size_t i = 0; i + 1 < columns; ++i) {
    summary.pairs.push_back(
        compare_columns(summary.columns[i], summary.columns[i + 1], summary.trials));
  }
  for (const GateConfig& gate : config.gates) {
    summary.gates.push_back(judge_gate(experiment, gate, summary));
  }
  summary.outcomes = count_outcomes(own);
  return summary;
}

std::vector<PairedComparison> compare_runs(const Experiment& first, const TrialTable& first_trials,
                                           const Experiment& second,
                                           const TrialTable& second_trials) {
  const auto same_key = [](const Cell& a, const Cell& b) { return a.key == b.key; };
  if (first.config().name != second.config().name || first.config().seed != second.config().seed ||
      !std::equal(first.cells().begin(), first.cells().end(), second.cells().begin(),
                  second.cells().end(), same_key)) {
    throw InputError(fmt::format(
        "'{}' and '{}' have no trials in common: only runs with the same experiment name, seed and "
        "cells can be paired",
        first.config().heading(), second.config().heading()));
  }
  const auto ours = successes_by_cell(first, trials_of(first, first_trials));
  const auto others = successes_by_cell(second, trials_of(second, second_trials));
  std::vector<PairedComparison> pairs;
  PairedComparison all{"all cells", "all cells"};
  for (const Cell& cell : first.cells()) {
    PairedComparison pair{cell.key, cell.key};
    add_pairs(ours[cell.index], others[cell.index], pair);
    all.only_first += pair.only_first;
    all.only_second += pair.only_second;
    pairs.push_back(pair);
  }
  if (pairs.size() > 1) pairs.push_back(all);
  for (PairedComparison& pair : pairs) pair.p = mcnemar_exact_p(pair.only_first, pair.only_second);
  return pairs;
}

}  // namespace binpick
