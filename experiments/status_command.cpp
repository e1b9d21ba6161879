#include "experiments/status_command.h"

#include <fmt/format.h>

#include <memory>

#include "experiments/present_results.h"
#include "experiments/result_summary.h"
#include "experiments/result_table.h"

namespace binpick {

void add_status_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto path = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("status", "Show how far a run is and its table so far");
  command->add_option("DIR", *path, "results folder")->required();
  command->callback([path, &registry, &exit_code] {
    const ResultFolder folder(*path);
    const RunResults results = folder.read();
    print_conflicts(results);
    const Experiment experiment = experiment_of(results.manifest, registry);
    const ResultSummary summary = summarize(experiment, results.trials);
    const char* state = folder.busy()        ? "running"
                        : summary.complete() ? "complete"
                                             : "stopped, `binpick run` goes on";
    fmt::print("{}: {} of {} trials, {}\n\n{}", experiment.config().name, summary.pooled.trials,
               summary.expected_trials, state, result_table(experiment, summary));
    exit_code = 0;
  });
}

}  // namespace binpick
