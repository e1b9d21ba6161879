#include "experiments/merge_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/run_status.h"
#include "experiments/write_file.h"
#include "models/errors.h"

namespace binpick {
namespace {

/// All stores that the arguments name, each a store or a folder of stores; sorted.
std::vector<std::filesystem::path> stores_of(const std::vector<std::string>& inputs) {
  std::vector<std::filesystem::path> stores;
  for (const std::string& input : inputs) {
    if (!std::filesystem::is_directory(input)) {
      stores.emplace_back(input);
      continue;
    }
    const auto found = ResultFolder(input).stores();
    if (found.empty()) {
      throw InputError(fmt::format("{}: no results here (trials*.sqlite), check the path", input));
    }
    stores.insert(stores.end(), found.begin(), found.end());
  }
  std::sort(stores.begin(), stores.end());
  return stores;
}

/// Writes the store aside and puts it in place when it is whole.
void write_store(const std::filesystem::path& file, const RunResults& results) {
  const std::filesystem::path aside = file.parent_path() / "merging.part";
  const std::filesystem::path journal = aside.string() + "-journal";
  std::filesystem::remove(aside);
  std::filesystem::remove(journal);
  ResultStore::open_for_run(aside, results.manifest).add_all(results.trials);
  std::filesystem::remove(journal);
  std::filesystem::remove(file.string() + "-journal");
  std::filesystem::rename(aside, file);
}

/// Says what the stores lack.
void print_missing(const Experiment& experiment, const std::vector<std::filesystem::path>& stores,
                   const RunResults& results) {
  const RunStatus status =
      run_status(experiment, stores, results, summarize(experiment, results.trials));
  for (const PartStatus& part : status.parts) {
    if (!part.shard || part.done == part.expected) continue;
    fmt::print(stderr, "{}: {} of {} trials, {}\n", part.store.string(), part.done, part.expected,
               part.writer ? "still running" : "it was stopped");
  }
  if (!status.missing.empty()) {
    fmt::print(stderr, "no store of {}\n", missing_text(status.missing));
  }
}

bool refused_for_conflicts(const RunResults& results) {
  if (results.conflicts.empty()) return false;
  print_conflicts(results);
  fmt::print(stderr, "nothing was merged: equal trials must have equal records\n");
  return true;
}

int merge(const std::string& out, const std::vector<std::string>& inputs,
          const TrialKindRegistry& registry) {
  const ResultFolder folder(std::filesystem::absolute(out).lexically_normal());
  const std::vector<std::filesystem::path> parts = stores_of(inputs);
  // Nothing is made before the inputs are known to fit.
  const RunResults joined = read_results(parts);
  if (refused_for_conflicts(joined)) return kExitGateFailed;
  const Experiment experiment = experiment_of(joined.manifest, registry);
  const FileDescriptor lock = folder.lock(std::nullopt, 0);
  std::vector<std::filesystem::path> stores = parts;
  const std::filesystem::path merged = folder.store_of(std::nullopt);
  if (std::filesystem::exists(merged)) stores.push_back(merged);
  const RunResults results = read_results(stores);
  if (refused_for_conflicts(results)) return kExitGateFailed;
  try {
    write_store(merged, results);
  } catch (const std::filesystem::filesystem_error& error) {
    throw IoError(error.what());
  }
  write_effective_config(folder, experiment);
  fmt::print(stderr, "{} trials of {} stores joined in {}\n", results.trials.size(), stores.size(),
             merged.string());
  print_missing(experiment, parts, results);
  return present_results(folder, experiment);
}

}  // namespace

void add_merge_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  struct Arguments {
    std::string out;
    std::vector<std::string> inputs;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("merge", "Join the results of shards into one store");
  command->add_option("OUT", arguments->out, "results folder to write")->required();
  command->add_option("IN", arguments->inputs, "results folders or trials*.sqlite files")
      ->required();
  command->callback([arguments, &registry, &exit_code] {
    exit_code = merge(arguments->out, arguments->inputs, registry);
  });
}

}  // namespace binpick
