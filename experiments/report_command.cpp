#include "experiments/report_command.h"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/report.h"
#include "experiments/report_traces.h"
#include "experiments/result_summary.h"

namespace binpick {

namespace {

/// @return whether the results are without conflicts.
bool report_on(const ResultFolder& folder, std::size_t replays, const TrialKindRegistry& registry) {
  const RunResults results = folder.read();
  print_conflicts(results);
  const Experiment experiment = experiment_of(results.manifest, registry);
  make_traces(folder, experiment, results,
              trials_to_trace(experiment, trials_of(experiment, results.trials), replays));
  const ResultSummary summary = summarize(experiment, results.trials);
  fmt::print("{}\n", write_report(folder, experiment, results, summary).string());
  return results.conflicts.empty();
}

}  // namespace

void add_report_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto paths = std::make_shared<std::vector<std::string>>();
  auto replays = std::make_shared<std::size_t>(10);
  CLI::App* command =
      app.add_subcommand("report", "Write report.html, trials.csv and trials.json of runs");
  command->add_option("DIR", *paths, "results folders")->required();
  command
      ->add_option("--replays", *replays,
                   "run so many trials again, failed ones first, to show them with pictures and in "
                   "3-D; they stay in DIR/traces")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  command->callback([paths, replays, &registry, &exit_code] {
    for (const std::string& path : *paths) {
      const ResultFolder folder(std::filesystem::absolute(path).lexically_normal());
      if (!report_on(folder, *replays, registry)) exit_code = kExitGateFailed;
    }
  });
}

}  // namespace binpick
