#pragma once

#include "experiments/experiment.h"
#include "experiments/result_folder.h"

namespace binpick {

/// Prints the table of the folder's results on stdout and, when no trial is missing, writes the
/// report and the exports into it.
/// @return the exit code: whether gates passed and no trial has two records.
[[nodiscard]] int present_results(const ResultFolder& folder, const Experiment& experiment);

/// Says on stderr which trials have two different records.
void print_conflicts(const RunResults& results);

/// Writes `config.yaml`: the effective configuration.
void write_effective_config(const ResultFolder& folder, const Experiment& experiment);

/// The experiment that made the results.
[[nodiscard]] Experiment experiment_of(const RunManifest& manifest,
                                       const TrialKindRegistry& registry);

}  // namespace binpick
