#pragma once

#include <string>

#include "experiments/experiment.h"
#include "experiments/result_folder.h"

namespace binpick {

// The canonical exports: sorted by trial key, without times and without anything of the host. Their
// bytes are the same for the same configuration, seed and binary, whatever the number of workers
// and shards and however often the run was interrupted.

/// One row per trial: cell, one column per axis, trial, outcome, stage, note, then the measures.
[[nodiscard]] std::string results_to_csv(const Experiment& experiment, const RunResults& results);

/// The run's identity and one object per trial.
[[nodiscard]] std::string results_to_json(const Experiment& experiment, const RunResults& results);

}  // namespace binpick
