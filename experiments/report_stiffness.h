#pragma once

#include <string>

#include "experiments/experiment.h"
#include "experiments/result_summary.h"

namespace binpick {

/// The part of the report about Table 1's two stiffnesses: maps of the rate over their plane, main
/// effects of either, rate and claims over whatever else is swept. Empty for experiments without
/// the axes K_t_y and K_r_x.
[[nodiscard]] std::string stiffness_section(const Experiment& experiment, const TrialTable& trials,
                                            const ResultSummary& summary);

}  // namespace binpick
