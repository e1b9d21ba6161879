#include "experiments/run_status.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace binpick {
namespace {

/// Trials of the run that the part's shard is to do, and those of them that are done.
void count_share(const Experiment& experiment, const TrialTable& trials, PartStatus& part) {
  for (const Cell& cell : experiment.cells()) {
    for (std::int64_t trial = 0; trial < experiment.config().trials; ++trial) {
      if (!part.shard->holds({cell.index, trial})) continue;
      ++part.expected;
      part.done += trials.contains({cell.key, trial}) ? 1 : 0;
    }
  }
}

/// Shards of the partitions that took part, which have no store and whose trials nobody else did.
std::vector<Shard> missing_shards(const Experiment& experiment, const TrialTable& trials,
                                  const std::vector<PartStatus>& parts) {
  std::map<std::int64_t, std::vector<bool>> present;  // by number of shards
  for (const PartStatus& part : parts) {
    if (!part.shard) continue;
    auto& indices = present[part.shard->count];
    indices.resize(static_cast<std::size_t>(part.shard->count));
    indices[static_cast<std::size_t>(part.shard->index)] = true;
  }
  std::vector<Shard> missing;
  for (const auto& [count, indices] : present) {
    for (std::int64_t i = 0; i < count; ++i) {
      if (indices[static_cast<std::size_t>(i)]) continue;
      PartStatus absent;
      absent.shard = Shard{i, count};
      count_share(experiment, trials, absent);
      if (absent.done < absent.expected) missing.push_back(*absent.shard);
    }
  }
  return missing;
}

std::optional<double> time_left_of(const PartStatus& part, double mean_time) {
  if (!part.writer || part.writer->workers < 1 || mean_time <= 0.0) return std::nullopt;
  return static_cast<double>(part.expected - part.done) * mean_time / part.writer->workers;
}

}  // namespace

bool RunStatus::running() const {
  return std::any_of(parts.begin(), parts.end(),
                     [](const PartStatus& part) { return part.writer.has_value(); });
}

std::string_view RunStatus::state() const {
  return running() ? "running" : complete ? "complete" : "stopped";
}

std::optional<double> RunStatus::time_left() const {
  std::optional<double> longest;
  for (const PartStatus& part : parts) {
    if (part.time_left) longest = std::max(longest.value_or(0.0), *part.time_left);
  }
  return longest;
}

RunStatus run_status(const Experiment& experiment, const std::vector<std::filesystem::path>& stores,
                     const RunResults& results, const ResultSummary& summary) {
  RunStatus status;
  status.done = summary.pooled.counts.trials;
  status.expected = summary.expected_trials;
  status.complete = summary.complete();
  status.open_ended = experiment.config().stopping.active() && !status.complete;
  const TrialTable trials = trials_of(experiment, results.trials);
  for (const auto& [key, trial] : trials) status.work_time += trial.wall_time;
  const double mean_time =
      trials.empty() ? 0.0 : status.work_time / static_cast<double>(trials.size());
  for (const std::filesystem::path& store : stores) {
    PartStatus part;
    part.store = store;
    part.shard = ResultFolder::shard_of(store);
    part.writer = ResultFolder::writer_of(store);
    if (part.shard) {
      count_share(experiment, trials, part);
    } else {
      part.done = status.done;
      part.expected = status.expected;
    }
    part.time_left = time_left_of(part, mean_time);
    status.parts.push_back(std::move(part));
  }
  status.missing = missing_shards(experiment, trials, status.parts);
  return status;
}

std::string missing_text(const std::vector<Shard>& missing) {
  std::map<std::int64_t, std::vector<std::int64_t>> by_count;
  for (const Shard& shard : missing) by_count[shard.count].push_back(shard.index);
  std::string text;
  for (const auto& [count, indices] : by_count) {
    text += fmt::format("{}shard{} {} of {}", text.empty() ? "" : "; ",
                        indices.size() == 1 ? "" : "s", fmt::join(indices, ", "), count);
  }
  return text;
}

}  // namespace binpick
