#include "experiments/report_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/report.h"
#include "experiments/report_traces.h"
#include "experiments/result_markdown.h"
#include "experiments/result_summary.h"

namespace binpick {

namespace {

struct ReportArguments {
  std::vector<std::string> folders;
  std::size_t replays = 10;
  bool markdown = false;
  std::string against;
};

/// A run as it lies in its folder.
struct FinishedRun {
  ResultFolder folder;
  RunResults results;
  Experiment experiment;

  FinishedRun(const std::string& path, const TrialKindRegistry& registry)
      : folder(std::filesystem::absolute(path).lexically_normal()),
        results(folder.read()),
        experiment(experiment_of(results.manifest, registry)) {
    print_conflicts(results);
  }
  [[nodiscard]] std::string name() const { return folder.path().filename().string(); }
};

void print_markdown(const FinishedRun& run, const std::optional<FinishedRun>& other) {
  fmt::print("{}\n", result_markdown(run.experiment, run.results,
                                     summarize(run.experiment, run.results.trials)));
  if (!other) return;
  const auto pairs =
      compare_runs(run.experiment, run.results.trials, other->experiment, other->results.trials);
  fmt::print("{}\n", paired_markdown(pairs, run.name(), other->name()));
}

void write_page(const FinishedRun& run, std::size_t replays) {
  const TrialTable trials = trials_of(run.experiment, run.results.trials);
  make_traces(run.folder, run.experiment, run.results,
              trials_to_trace(run.experiment, trials, replays));
  const ResultSummary summary = summarize(run.experiment, run.results.trials);
  fmt::print("{}\n", write_report(run.folder, run.experiment, run.results, summary).string());
}

/// @return whether all results are without conflicts.
bool report(const ReportArguments& arguments, const TrialKindRegistry& registry) {
  std::optional<FinishedRun> other;
  if (!arguments.against.empty()) other.emplace(arguments.against, registry);
  bool fine = true;
  for (const std::string& folder : arguments.folders) {
    const FinishedRun run(folder, registry);
    fine &= run.results.conflicts.empty();
    if (arguments.markdown) {
      print_markdown(run, other);
    } else {
      write_page(run, arguments.replays);
    }
  }
  return fine;
}

}  // namespace

void add_report_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command =
      app.add_subcommand("report", "Write report.html, trials.csv and trials.json of runs");
  command->add_option("DIR", arguments->folders, "results folders")->required();
  command
      ->add_option("--replays", arguments->replays,
                   "run so many trials again, failed ones first, to show them with pictures and in "
                   "3-D; they stay in DIR/traces")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  CLI::Option* markdown = command->add_flag(
      "--markdown", arguments->markdown,
      "print the tables, intervals and claims as Markdown instead; nothing is written");
  command
      ->add_option("--against", arguments->against,
                   "with --markdown: the results folder of another robot on the same trials, to "
                   "compare with trial by trial (McNemar)")
      ->needs(markdown);
  command->callback([arguments, &registry, &exit_code] {
    if (!report(*arguments, registry)) exit_code = kExitGateFailed;
  });
}

}  // namespace binpick
