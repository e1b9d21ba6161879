#pragma once

#include <string>

#include "experiments/experiment.h"
#include "experiments/result_store.h"

namespace binpick {

/// The part of the report that shows a recognition experiment as the paper shows it (IJRR 2012,
/// Figs. 10, 12, 13): plots and one table, the paper's claim beside what came out, as HTML. Empty
/// for experiments of other kinds. A pure function of its arguments.
[[nodiscard]] std::string recognition_section(const Experiment& experiment,
                                              const TrialTable& trials);

}  // namespace binpick
