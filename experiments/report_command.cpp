#include "experiments/report_command.h"

#include <fmt/format.h>

#include <memory>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/report.h"
#include "experiments/report_traces.h"
#include "experiments/result_summary.h"

namespace binpick {

void add_report_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto path = std::make_shared<std::string>();
  auto replays = std::make_shared<std::size_t>(10);
  CLI::App* command =
      app.add_subcommand("report", "Write report.html, trials.csv and trials.json of a run");
  command->add_option("DIR", *path, "results folder")->required();
  command
      ->add_option("--replays", *replays,
                   "run so many trials again, failed ones first, to show them with pictures and in "
                   "3-D; they stay in DIR/traces")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  command->callback([path, replays, &registry, &exit_code] {
    const ResultFolder folder(std::filesystem::absolute(*path).lexically_normal());
    const RunResults results = folder.read();
    print_conflicts(results);
    const Experiment experiment = experiment_of(results.manifest, registry);
    make_traces(folder, experiment, results,
                trials_to_trace(experiment, trials_of(experiment, results.trials), *replays));
    const ResultSummary summary = summarize(experiment, results.trials);
    fmt::print("{}\n", write_report(folder, experiment, results, summary).string());
    exit_code = results.conflicts.empty() ? kExitOk : kExitGateFailed;
  });
}

}  // namespace binpick
