#include "experiments/report_command.h"

#include <fmt/format.h>

#include <memory>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/report.h"

namespace binpick {

void add_report_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto path = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("report", "Write report.html, trials.csv and trials.json of a run");
  command->add_option("DIR", *path, "results folder")->required();
  command->callback([path, &registry, &exit_code] {
    const ResultFolder folder(std::filesystem::absolute(*path).lexically_normal());
    const RunResults results = folder.read();
    print_conflicts(results);
    const Experiment experiment = experiment_of(results.manifest, registry);
    fmt::print("{}\n", write_report(folder, experiment, results).string());
    exit_code = results.conflicts.empty() ? kExitOk : kExitGateFailed;
  });
}

}  // namespace binpick
