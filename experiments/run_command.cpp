#include "experiments/run_command.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <optional>

#include "experiments/exit_codes.h"
#include "experiments/experiment.h"
#include "experiments/present_results.h"
#include "experiments/progress.h"
#include "experiments/result_folder.h"
#include "experiments/runner.h"
#include "experiments/shard.h"
#include "experiments/trial_quota.h"
#include "models/errors.h"

namespace binpick {
namespace {

constexpr int kMaxWorkers = 1024;

struct RunArguments {
  std::string config;
  std::vector<std::string> settings;
  std::optional<std::int64_t> trials;
  std::optional<std::int64_t> seed;
  std::optional<std::string> out;
  std::optional<std::string> shard;
  int workers = 0;
  bool fresh = false;
};

int available_cores() {
  cpu_set_t cores;
  if (::sched_getaffinity(0, sizeof cores, &cores) != 0) return 1;
  return std::max(1, CPU_COUNT(&cores));
}

Experiment load_experiment(const RunArguments& arguments, const TrialKindRegistry& registry) {
  std::vector<ConfigOverride> overrides;
  for (const std::string& setting : arguments.settings) {
    overrides.push_back(ConfigOverride::parse(setting));
  }
  if (arguments.trials) overrides.push_back({"trials", fmt::format("{}", *arguments.trials)});
  if (arguments.seed) overrides.push_back({"seed", fmt::format("{}", *arguments.seed)});
  return Experiment::load(arguments.config, overrides, registry);
}

/// One run: from what the folder holds already to what it holds afterwards.
class RunCommand {
 public:
  RunCommand(const RunArguments& arguments, const TrialKindRegistry& registry)
      : arguments_(arguments),
        experiment_(load_experiment(arguments, registry)),
        manifest_(RunManifest::of(experiment_)),
        folder_(std::filesystem::absolute(arguments.out ? std::filesystem::path(*arguments.out)
                                                        : ResultFolder::default_path(experiment_))),
        shard_(arguments.shard ? Shard::parse(*arguments.shard) : Shard::from_environment()),
        quota_(experiment_) {
    if (shard_ && experiment_.config().stopping.active()) {
      throw InputError(fmt::format(
          "{}: shards do not go with 'stopping', which has to see all trials of a cell: leave "
          "--shard out (outside of a job array), or --set stopping.half_width=0",
          arguments.config));
    }
    if (!arguments.fresh) finished_ = read_finished();
    total_ = count_total();
  }

  int execute() {
    const std::vector<Job> jobs = missing_jobs();
    if (!jobs.empty()) {
      if (const auto signal = run(jobs)) {
        fmt::print(stderr, "stopped; finished trials are kept in {}, the same command goes on\n",
                   folder_.path().string());
        return kExitSignal + *signal;
      }
    } else {
      open_store();
      fmt::print(stderr, "{}: nothing left to do\n", experiment_.config().name);
    }
    return present_results(folder_, experiment_);
  }

 private:
  /// The trials of all stores in the folder.
  TrialTable read_finished() const {
    TrialTable finished;
    for (const std::filesystem::path& file : folder_.stores()) {
      ResultStore store = ResultStore::open_to_read(file);
      const std::string conflict = manifest_.conflict_with(store.manifest());
      if (!conflict.empty()) {
        throw InputError(fmt::format("{}: holds {}; give another --out, or --fresh to start over",
                                     file.string(), conflict));
      }
      finished.merge(store.trials());
    }
    return finished;
  }

  std::vector<Job> missing_jobs() const {
    std::vector<Job> jobs = quota_.missing(finished_);
    const auto of_others = [&](const Job& job) { return shard_ && !shard_->holds(job); };
    jobs.erase(std::remove_if(jobs.begin(), jobs.end(), of_others), jobs.end());
    return jobs;
  }

  std::int64_t count_total() const {
    if (!shard_) return quota_.expected(finished_);
    std::int64_t total = 0;
    for (std::int64_t i = 0; i < experiment_.job_count(); ++i) {
      total += shard_->holds(experiment_.job(i)) ? 1 : 0;
    }
    return total;
  }

  std::int64_t count_done() const {
    return shard_ ? total_ - std::ssize(missing_jobs()) : std::ssize(quota_.select(finished_));
  }

  int workers() const { return arguments_.workers > 0 ? arguments_.workers : available_cores(); }

  void open_store() {
    lock_ = folder_.lock(shard_, workers());
    if (arguments_.fresh) folder_.clear(shard_);
    write_effective_config(folder_, experiment_);
    store_.emplace(ResultStore::open_for_run(folder_.store_of(shard_), manifest_));
    // The folder was read before it was locked.
    for (const auto& [key, trial] : store_->trials()) {
      if (finished_.contains(key)) continue;
      throw InputError(fmt::format("{}: another run has written here in the meantime; run again",
                                   folder_.store_of(shard_).string()));
    }
  }

  std::optional<int> run(const std::vector<Job>& jobs) {
    std::optional<Progress> progress;
    RunEvents events;
    events.inputs_accepted = [&] {
      open_store();
      fmt::print(stderr, "results go to {}\n", folder_.path().string());
      progress.emplace(experiment_.config().name, count_done(), total_);
    };
    events.trial_finished = [&](const TrialKey& key, const StoredTrial& trial) {
      store_->add(key, trial);
      finished_.emplace(key, trial);
      progress->trial_finished(trial.record.outcome == TrialOutcome::kSuccess);
    };
    events.log = [&](std::string_view line) {
      progress ? progress->log(line) : fmt::print(stderr, "{}\n", line);
    };
    events.more_jobs = [&] {
      if (progress && !shard_) progress->expect(quota_.expected(finished_));
      return missing_jobs();
    };
    events.tick = [&] {
      if (progress) progress->refresh();
    };
    Runner runner(experiment_, jobs, {workers(), folder_.path()}, events);
    return runner.run();
  }

  const RunArguments& arguments_;
  Experiment experiment_;
  RunManifest manifest_;
  ResultFolder folder_;
  std::optional<Shard> shard_;
  TrialQuota quota_;
  TrialTable finished_;
  std::int64_t total_ = 0;
  FileDescriptor lock_;
  std::optional<ResultStore> store_;
};

}  // namespace

void add_run_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand(
      "run", "Run an experiment: the trials that its results folder does not hold yet");
  command->add_option("CONFIG", arguments->config, "experiment file (YAML)")->required();
  command
      ->add_option("--set", arguments->settings,
                   "path=value, put in place of the file's value; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--trials", arguments->trials, "trials per cell");
  command->add_option("--seed", arguments->seed, "master seed");
  command->add_option("--out", arguments->out,
                      "results folder [results/<experiment>-<hash of the configuration>]");
  command->add_option("--workers", arguments->workers, "worker processes [one per core]")
      ->check(CLI::Range(1, kMaxWorkers));
  command->add_option("--shard", arguments->shard,
                      "i/n: only part i (from 0) of n [from the Slurm array's environment]");
  command->add_flag("--fresh", arguments->fresh, "drop earlier results of the folder");
  command->callback([arguments, &registry, &exit_code] {
    exit_code = RunCommand(*arguments, registry).execute();
  });
}

}  // namespace binpick
