#include "experiments/present_results.h"

#include <fmt/format.h>

#include <cstdio>

#include "experiments/exit_codes.h"
#include "experiments/report.h"
#include "experiments/result_summary.h"
#include "experiments/result_table.h"
#include "experiments/write_file.h"

namespace binpick {

void print_conflicts(const RunResults& results) {
  for (const TrialKey& key : results.conflicts) {
    fmt::print(stderr, "conflict: trial {} of cell {} has two different records\n", key.trial,
               key.cell);
  }
}

int present_results(const ResultFolder& folder, const Experiment& experiment) {
  const RunResults results = folder.read(&experiment);
  print_conflicts(results);
  const ResultSummary summary = summarize(experiment, results.trials);
  fmt::print("{}\n", result_table(experiment, summary));
  if (summary.complete()) {
    fmt::print("report: {}\n", write_report(folder, experiment, results, summary).string());
  } else {
    fmt::print("{} of {} trials are there: run what is missing, or merge the other shards\n",
               summary.pooled.counts.trials, summary.expected_trials);
  }
  const bool fine = results.conflicts.empty() && summary.gates_passed();
  return fine ? kExitOk : kExitGateFailed;
}

void write_effective_config(const ResultFolder& folder, const Experiment& experiment) {
  write_file(folder.path() / "config.yaml",
             fmt::format("# Effective configuration; relative paths start at {}\n{}",
                         experiment.directory().string(), experiment.effective_yaml()));
}

Experiment experiment_of(const RunManifest& manifest, const TrialKindRegistry& registry) {
  return Experiment::from_text(manifest.yaml, "effective configuration of " + manifest.experiment,
                               manifest.directory, registry);
}

}  // namespace binpick
