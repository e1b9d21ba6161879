#include "experiments/trial_quota.h"

#include <algorithm>

namespace binpick {
namespace {

/// Whether trials 0, 1, ... of the cell succeeded, up to the first that is missing.
std::vector<bool> unbroken_successes(const Cell& cell, const TrialTable& trials) {
  std::vector<bool> successes;
  auto trial = trials.lower_bound({cell.key, 0});
  for (std::int64_t i = 0; trial != trials.end() && trial->first == TrialKey{cell.key, i}; ++i) {
    successes.push_back(trial->second.record.outcome == TrialOutcome::kSuccess);
    ++trial;
  }
  return successes;
}

}  // namespace

TrialQuota::TrialQuota(const Experiment& experiment) : experiment_(experiment) {
  const ExperimentConfig& config = experiment.config();
  if (config.stopping.active()) plan_.emplace(config.stopping, config.trials);
}

std::int64_t TrialQuota::of(const Cell& cell, const TrialTable& trials) const {
  return plan_ ? plan_->size(unbroken_successes(cell, trials)) : experiment_.config().trials;
}

TrialTable TrialQuota::select(const TrialTable& table) const {
  TrialTable selected;
  for (const Cell& cell : experiment_.cells()) {
    selected.insert(table.lower_bound({cell.key, 0}),
                    table.lower_bound({cell.key, of(cell, table)}));
  }
  return selected;
}

std::vector<Job> TrialQuota::missing(const TrialTable& trials) const {
  std::vector<std::int64_t> quotas;
  for (const Cell& cell : experiment_.cells()) quotas.push_back(of(cell, trials));
  std::vector<Job> jobs;
  for (std::int64_t i = 0; i < experiment_.job_count(); ++i) {
    const Job job = experiment_.job(i);
    if (job.trial < quotas[job.cell] &&
        !trials.contains({experiment_.cells()[job.cell].key, job.trial})) {
      jobs.push_back(job);
    }
  }
  return jobs;
}

std::int64_t TrialQuota::expected(const TrialTable& trials) const {
  std::int64_t expected = 0;
  for (const Cell& cell : experiment_.cells()) {
    const std::int64_t quota = of(cell, trials);
    const auto there = static_cast<std::int64_t>(unbroken_successes(cell, trials).size());
    expected += there >= quota ? quota : experiment_.config().trials;
  }
  return expected;
}

Interval TrialQuota::interval(const Proportion& proportion) const {
  return plan_ ? plan_->interval(proportion) : wilson_interval(proportion);
}

}  // namespace binpick
