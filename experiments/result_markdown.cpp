#include "experiments/result_markdown.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/result_table.h"
#include "experiments/stiffness_claims.h"

namespace binpick {
namespace {

std::string rate_text(const Proportion& rate, const Interval& interval) {
  if (rate.trials == 0) return "";
  return fmt::format("{:.1f} {}", 100.0 * rate.rate(), interval_text(interval));
}

std::string claim_text(const StiffnessClaim& claim) {
  return fmt::format("{:+.1f} {}, {}", 100.0 * claim.difference, interval_text(claim.interval),
                     to_text(claim.verdict));
}

std::string origin_line(const Experiment& experiment, const RunResults& results,
                        const ResultSummary& summary) {
  const RunManifest& manifest = results.manifest;
  return fmt::format("{} of {} trials, experiment `{}`, seed {}, binpick {} (build {}).\n",
                     summary.pooled.counts.trials, summary.expected_trials, manifest.experiment,
                     experiment.config().seed, manifest.program, manifest.build);
}

/// Success over K_t,y (rows) and K_r,x (columns), in percent.
std::string plane_map(const StiffnessPlane& plane, const ResultSummary& summary) {
  std::vector<std::string> header{"K_t,y \\ K_r,x"};
  header.insert(header.end(), plane.rotation.begin(), plane.rotation.end());
  TextTable table(header);
  for (std::size_t row = 0; row < plane.cells.size(); ++row) {
    std::vector<std::string> texts{plane.translation[row]};
    for (const std::size_t index : plane.cells[row]) {
      const CellSummary& cell = summary.cells[index];
      texts.push_back(rate_text(cell.ours, cell.interval));
    }
    table.add_row(std::move(texts));
  }
  return fmt::format("Success in %, {}:\n\n{}\n", plane.name(), table.markdown());
}

/// One row per plane: its rate over all stiffnesses, and the claims; the last row is what flat
/// worlds get.
std::string plane_table(const std::vector<StiffnessPlane>& planes, const Experiment& experiment,
                        const ResultSummary& summary) {
  const auto judged = std::find_if(planes.begin(), planes.end(), [](const StiffnessPlane& plane) {
    return plane.outcomes.has_value();
  });
  std::vector<std::string> header{"trials", "number", "rate, %"};
  if (judged != planes.end()) {
    header.insert(header.end(), {"a: soft is better", "b: the best cell is soft",
                                 "c: the paper's best three are better"});
  }
  TextTable table(header);
  for (const StiffnessPlane& plane : planes) {
    const PooledRate rate = plane.pooled(summary);
    std::vector<std::string> texts{plane.name(), fmt::format("{}", rate.counts.trials),
                                   rate_text(rate.counts, rate.interval)};
    if (plane.outcomes) {
      for (const StiffnessClaim& claim : claims_about(plane, experiment)) {
        texts.push_back(claim_text(claim));
      }
    }
    table.add_row(std::move(texts));
  }
  if (judged == planes.end()) return table.markdown() + "\n";
  std::vector<std::string> flat{"worlds of one flat rate", "", percent_text(kFlatRate)};
  for (const double share : flat_claim_shares(*judged, experiment)) {
    flat.push_back(fmt::format("confirmed in {:.1f} %", 100.0 * share));
  }
  table.add_row(std::move(flat));
  return table.markdown() +
         "\nDifferences of rates in points, 95 % bootstrap intervals over trial numbers; verdicts "
         "at 5 % with Holm's correction over the three.\n\n";
}

std::string rates(const Experiment& experiment, const ResultSummary& summary,
                  const std::vector<StiffnessPlane>& planes) {
  if (planes.empty() || summary.has_paper()) {
    return cell_table(experiment, summary).markdown() + "\n";
  }
  if (planes.size() > kMostMaps) return "";
  std::string maps;
  for (const StiffnessPlane& plane : planes) maps += plane_map(plane, summary);
  return maps;
}

}  // namespace

std::string result_markdown(const Experiment& experiment, const RunResults& results,
                            const ResultSummary& summary) {
  const auto planes = stiffness_planes(experiment, trials_of(experiment, results.trials));
  std::string text = fmt::format("### {}\n\n{}\n", experiment.config().heading(),
                                 origin_line(experiment, results, summary));
  text += rates(experiment, summary, planes);
  if (!planes.empty()) text += plane_table(planes, experiment, summary);
  // Of a map's columns and of a sweep's lines together they say nothing.
  if (planes.empty() || planes.size() == summary.columns.size()) {
    for (const std::string& statement : table_statements(experiment, summary)) {
      text += "* " + statement + "\n";
    }
    text += "\n";
  }
  return text + outcome_table(summary).markdown();
}

std::string paired_markdown(const std::vector<PairedComparison>& pairs, const std::string& first,
                            const std::string& second) {
  TextTable table({"trials of the same number", fmt::format("{} alone succeeds", first),
                   fmt::format("{} alone succeeds", second), "McNemar, exact"});
  for (const PairedComparison& pair : pairs) {
    table.add_row({pair.first, fmt::format("{}", pair.only_first),
                   fmt::format("{}", pair.only_second), p_text(pair.p)});
  }
  return table.markdown();
}

}  // namespace binpick
