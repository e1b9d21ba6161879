#pragma once

#include <string>

#include "experiments/experiment.h"
#include "experiments/result_folder.h"
#include "experiments/result_summary.h"

namespace binpick {

/// A run's results as Markdown, for a handbook's page: where they come from; a row per cell with
/// intervals beside the paper's counts (of sweeps over Table 1's stiffnesses a row per swept value,
/// of finer stiffness planes a map); what the table supports; the claims of Table 1, each beside
/// what flat worlds get; how trials ended. `summary` is that of `results`. A pure function.
[[nodiscard]] std::string result_markdown(const Experiment& experiment, const RunResults& results,
                                          const ResultSummary& summary);

/// Two runs compared trial by trial (see compare_runs) as a Markdown table; the names head columns.
[[nodiscard]] std::string paired_markdown(const std::vector<PairedComparison>& pairs,
                                          const std::string& first, const std::string& second);

}  // namespace binpick
