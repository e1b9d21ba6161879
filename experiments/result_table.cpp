#include "experiments/result_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace binpick {
namespace {

constexpr double kSignificance = 0.05;

std::string fits_text(const CellSummary& cell) {
  if (!cell.paper_p) return "";
  return *cell.paper_p >= kSignificance ? "yes" : fmt::format("no, p={:.2g}", *cell.paper_p);
}

std::vector<std::string> header_of(const ExperimentConfig& config, const ResultSummary& summary,
                                   bool with_paper) {
  std::vector<std::string> header;
  const auto axis = column_axis(config);
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (i != axis) header.push_back(config.axes[i].name);
  }
  for (const ColumnSummary& column : summary.columns) {
    header.push_back(axis ? fmt::format("{} {}", config.axes[*axis].name, column.label) : "ours");
    header.insert(header.end(), {"%", "95 % interval"});
    if (with_paper) header.push_back("fits");
  }
  if (with_paper) header.insert(header.end(), {"paper", "%"});
  return header;
}

std::string of_column(const Experiment& experiment, const ColumnSummary& column) {
  const auto axis = column_axis(experiment.config());
  if (!axis) return "";
  return fmt::format(" ({} {})", experiment.config().axes[*axis].name, column.label);
}

std::vector<std::string> comparison_statements(const ColumnSummary& column,
                                               const std::string& which) {
  const TableComparison& comparison = *column.comparison;
  const FlatReference& flat = *column.flat;
  const std::string flat_rate = percent_text(comparison.flat_rate);
  return {
      fmt::format("paper's counts given our rates{}: deviance {:.1f}, bootstrap p = {:.2g}: {}; a "
                  "world of one flat rate of {} would pass this check in {:.0f} % of all cases",
                  which, comparison.deviance, comparison.bootstrap_p,
                  comparison.bootstrap_p > kSignificance ? "compatible" : "not compatible",
                  flat_rate, 100.0 * flat.compatible_share),
      fmt::format(
          "log-likelihood of the paper's counts{}: {:+.2f} nats against the flat rate of {} "
          "(the paper's own table: {:+.2f}); a flat world of as many trials would get {:+.2f} "
          "to {:+.2f}, and more than 0 in {:.0f} % of all cases",
          which, comparison.gain_over_flat, flat_rate, comparison.highest_gain, flat.gain.low,
          flat.gain.high, 100.0 * flat.better_share)};
}

std::string gate_line(const GateResult& gate) {
  return fmt::format("gate {}: {} = {} {}, demanded {}: {}\n", gate.passed ? "passed" : "FAILED",
                     counts_text(gate.ours), percent_text(gate.ours.rate()),
                     interval_text(gate.interval), percent_text(gate.minimum_rate), gate.cell);
}

}  // namespace

TextTable cell_table(const Experiment& experiment, const ResultSummary& summary) {
  const ExperimentConfig& config = experiment.config();
  const bool with_paper = summary.has_paper();
  TextTable table(header_of(config, summary, with_paper));
  const auto axis = column_axis(config);
  for (std::size_t row = 0; row < summary.columns.front().cells.size(); ++row) {
    std::vector<std::string> texts;
    const Cell& first = experiment.cells()[summary.columns.front().cells[row]];
    for (std::size_t i = 0; i < config.axes.size(); ++i) {
      if (i != axis) texts.push_back(config.axes[i].label(first.values[i]));
    }
    for (const ColumnSummary& column : summary.columns) {
      const CellSummary& cell = summary.cells[column.cells[row]];
      texts.push_back(counts_text(cell.ours));
      texts.push_back(cell.ours.trials == 0 ? "" : fmt::format("{:.1f}", 100.0 * cell.ours.rate()));
      texts.push_back(cell.ours.trials == 0 ? "" : interval_text(cell.interval));
      if (with_paper) texts.push_back(fits_text(cell));
    }
    const auto& paper = summary.cells[first.index].paper;
    if (paper) {
      texts.push_back(counts_text(*paper));
      texts.push_back(fmt::format("{:.0f}", 100.0 * paper->rate()));
    }
    table.add_row(std::move(texts));
  }
  return table;
}

TextTable outcome_table(const ResultSummary& summary) {
  TextTable table({"outcome", "stage", "trials", "%"});
  for (const OutcomeCount& each : summary.outcomes) {
    const Proportion share{each.count, summary.pooled.counts.trials};
    const bool success = each.outcome == TrialOutcome::kSuccess;
    table.add_row({std::string(to_text(each.outcome)),
                   success ? "" : std::string(to_text(each.stage)), fmt::format("{}", each.count),
                   fmt::format("{:.1f}", 100.0 * share.rate())});
  }
  return table;
}

std::string counts_text(const Proportion& proportion) {
  return fmt::format("{}/{}", proportion.successes, proportion.trials);
}

std::string p_text(double p) { return p > 0.0 ? fmt::format("p = {:.2g}", p) : "p < 1e-300"; }

std::string percent_text(double rate) { return fmt::format("{:.1f} %", 100.0 * rate); }

std::string axis_heading(const AxisConfig& axis) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kUnits{{
      {"translation", "N/m"},
      {"rotation", "Nm/rad"},
      {"stiffness_z", "N/m"},
      {"force", "N"},
      {"speed", "m/s"},
      {"_deg", "degrees"},
      {"_percent", "%"},
      {"_offset", "m"},
      {"pose_error", "m"},
      {"pre_opening", "m"},
      {"pad_width", "m"},
      {"grasp_raise", "m"},
      {"mass", "kg"},
  }};
  if (axis.key == "torque_offset") return axis.name + ", Nm";
  for (const auto& [part, unit] : kUnits) {
    if (axis.key.substr(axis.key.rfind('.') + 1).find(part) == std::string::npos) continue;
    return fmt::format("{}, {}", axis.name, unit);
  }
  return axis.name;
}

std::string digits_text(double value, int digits) {
  const bool large = std::abs(value) >= std::pow(10.0, digits) && std::abs(value) < 1e9;
  return large ? fmt::format("{:.0f}", value) : fmt::format("{:.{}g}", value, digits);
}

std::string interval_text(const Interval& interval) {
  return fmt::format("[{:.1f}, {:.1f}]", 100.0 * interval.low, 100.0 * interval.high);
}

std::vector<std::string> table_statements(const Experiment& experiment,
                                          const ResultSummary& summary) {
  std::vector<std::string> statements;
  for (const ColumnSummary& column : summary.columns) {
    if (column.pooled.counts.trials == 0) continue;
    const std::string which = of_column(experiment, column);
    statements.push_back(fmt::format("all cells{}: {} = {}, 95 % interval{} {}", which,
                                     counts_text(column.pooled.counts),
                                     percent_text(column.pooled.counts.rate()),
                                     column.cells.size() > 1 ? " over trial numbers" : "",
                                     interval_text(column.pooled.interval)));
    if (column.homogeneity.degrees_of_freedom > 0) {
      statements.push_back(
          fmt::format("cells alike{}? chi-square {:.1f} on {} degrees of freedom, {}", which,
                      column.homogeneity.chi_square, column.homogeneity.degrees_of_freedom,
                      p_text(column.homogeneity.p)));
    }
    if (column.comparison && column.flat) {
      for (std::string& each : comparison_statements(column, which)) {
        statements.push_back(std::move(each));
      }
    }
  }
  for (const PairedComparison& pair : summary.pairs) {
    statements.push_back(
        fmt::format("paired trials, {} against {}: {} succeed in the first alone, {} in the second "
                    "alone, McNemar {}",
                    pair.first, pair.second, pair.only_first, pair.only_second, p_text(pair.p)));
  }
  return statements;
}

std::string result_table(const Experiment& experiment, const ResultSummary& summary) {
  const ExperimentConfig& config = experiment.config();
  std::string text = config.heading() + "\n\n";
  text += cell_table(experiment, summary).text() + "\n";
  for (const std::string& statement : table_statements(experiment, summary)) {
    text += statement + "\n";
  }
  text += fmt::format("\n{}{}", outcome_table(summary).text(), summary.gates.empty() ? "" : "\n");
  for (const GateResult& gate : summary.gates) text += gate_line(gate);
  return text;
}

}  // namespace binpick
