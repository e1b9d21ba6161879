#include "experiments/reproduce_command.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/report_traces.h"
#include "experiments/run_trial.h"
#include "experiments/trial_choice.h"
#include "models/errors.h"

namespace binpick {
namespace {

struct ReproduceArguments {
  std::string source;
  TrialChoice choice;
  std::vector<std::string> settings;
  std::optional<std::string> video;
  std::optional<std::string> trace;
};

std::optional<std::filesystem::path> absolute(const std::optional<std::string>& path) {
  if (!path) return std::nullopt;
  return std::filesystem::absolute(*path);
}

TrialRecord run_again(const Experiment& experiment, const ReproduceArguments& arguments) {
  const Cell& cell = experiment.cell(arguments.choice.cell);
  const TrialContext context{experiment.seeds(cell, arguments.choice.trial),
                             arguments.choice.trial,
                             absolute(arguments.video),
                             absolute(arguments.trace),
                             {}};
  return run_single_trial(experiment, cell, context);
}

int reproduce_from_config(const ReproduceArguments& arguments, const TrialKindRegistry& registry) {
  std::vector<ConfigOverride> overrides;
  for (const std::string& setting : arguments.settings) {
    overrides.push_back(ConfigOverride::parse(setting));
  }
  const Experiment experiment = Experiment::load(arguments.source, overrides, registry);
  fmt::print("{}\n", to_json(run_again(experiment, arguments)));
  return kExitOk;
}

void warn_about_differences(const RunManifest& stored, const RunManifest& now) {
  const std::string conflict = now.conflict_with(stored);
  if (!conflict.empty()) fmt::print(stderr, "note: these are {}\n", conflict);
  if (stored.cpu != now.cpu) {
    fmt::print(stderr, "note: made on processor class '{}', this is '{}'\n", stored.cpu, now.cpu);
  }
}

int reproduce_from_results(const ReproduceArguments& arguments, const TrialKindRegistry& registry) {
  if (!arguments.settings.empty()) {
    throw InputError("--set: stored trials run as they ran; give a configuration file instead");
  }
  const RunResults results = ResultFolder(arguments.source).read();
  const Experiment experiment = experiment_of(results.manifest, registry);
  const TrialKey key{experiment.cell(arguments.choice.cell).key, arguments.choice.trial};
  const TrialRecord& stored = results.trial(key).record;
  warn_about_differences(results.manifest, RunManifest::of(experiment));
  if (stored.outcome == TrialOutcome::kCrashed) {
    fmt::print(stderr, "note: this trial crashed ({}); it may end this process too\n", stored.note);
  }
  const TrialRecord again = run_again(experiment, arguments);
  if (arguments.trace) sign_trace(*absolute(arguments.trace), results.manifest, again);
  const bool same = identical(again, stored);
  fmt::print("{}\n", to_json(again));
  if (!same) fmt::print("{}\n", to_json(stored));
  fmt::print("{}\n", same ? "identical" : "differs");
  return same ? kExitOk : kExitGateFailed;
}

}  // namespace

void add_reproduce_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto arguments = std::make_shared<ReproduceArguments>();
  CLI::App* command = app.add_subcommand(
      "reproduce", "Run one trial again and compare it with the stored one, bit for bit");
  command->add_option("SOURCE", arguments->source, "results folder, or experiment file (YAML)")
      ->required();
  add_trial_choice(*command, arguments->choice);
  command
      ->add_option("--set", arguments->settings,
                   "path=value, with an experiment file only; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--video", arguments->video, "film the trial into this file");
  command->add_option("--trace", arguments->trace, "write the trial's signals into this folder");
  command->callback([arguments, &registry, &exit_code] {
    exit_code = std::filesystem::is_directory(arguments->source)
                    ? reproduce_from_results(*arguments, registry)
                    : reproduce_from_config(*arguments, registry);
  });
}

}  // namespace binpick
