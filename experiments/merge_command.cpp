#include "experiments/merge_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
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

int merge(const std::string& out, const std::vector<std::string>& inputs,
          const TrialKindRegistry& registry) {
  const ResultFolder folder(std::filesystem::absolute(out).lexically_normal());
  std::vector<std::filesystem::path> stores = stores_of(inputs);
  const std::filesystem::path merged = folder.store_of(std::nullopt);
  if (std::filesystem::exists(merged)) stores.push_back(merged);
  const RunResults results = read_results(stores);
  if (!results.conflicts.empty()) {
    print_conflicts(results);
    fmt::print(stderr, "nothing was merged: equal trials must have equal records\n");
    return kExitGateFailed;
  }
  const Experiment experiment = experiment_of(results.manifest, registry);
  const FileDescriptor lock = folder.lock(std::nullopt);
  try {
    write_store(merged, results);
  } catch (const std::filesystem::filesystem_error& error) {
    throw IoError(error.what());
  }
  write_effective_config(folder, experiment);
  fmt::print(stderr, "{} trials of {} stores joined in {}\n", results.trials.size(), stores.size(),
             merged.string());
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
