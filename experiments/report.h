#pragma once

#include <filesystem>
#include <string>

#include "experiments/experiment.h"
#include "experiments/report_replays.h"
#include "experiments/result_folder.h"
#include "experiments/result_summary.h"

namespace binpick {

/// The report as one self-contained HTML page: tables and bars with intervals beside the paper's,
/// failures by outcome and stage, every failed trial with the command that reproduces it, single
/// trials as `shown`, the effective configuration, the manifest. `summary` is that of `results`;
/// `folder` is the path that those commands name. A pure function of its arguments.
[[nodiscard]] std::string report_html(const Experiment& experiment, const RunResults& results,
                                      const ResultSummary& summary, const std::string& folder,
                                      const TraceSection& shown = {});

/// Writes `report.html`, `trials.csv` and `trials.json` into the folder. Trials whose traces lie
/// there already are shown with pictures and replays.
/// @return the path of the report.
std::filesystem::path write_report(const ResultFolder& folder, const Experiment& experiment,
                                   const RunResults& results, const ResultSummary& summary);

}  // namespace binpick
