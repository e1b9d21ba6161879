#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/result_store.h"
#include "experiments/stopping_rule.h"

namespace binpick {

/// How many trials each cell of an experiment is to have: its number of trials or, under a stopping
/// rule, what the trials that are there ask for.
class TrialQuota {
 public:
  explicit TrialQuota(const Experiment& experiment);

  /// Trials 0 to this, exclusively, belong to the cell, those that are missing included.
  [[nodiscard]] std::int64_t of(const Cell& cell, const TrialTable& trials) const;
  /// The trials of `table` that belong to the experiment: others (of a larger earlier run in the
  /// same folder) are left out.
  [[nodiscard]] TrialTable select(const TrialTable& table) const;
  /// What is to be done next, in the order of the jobs' numbers; under a stopping rule one block
  /// per cell that needs it, and more once these are there. Empty when nothing is missing.
  [[nodiscard]] std::vector<Job> missing(const TrialTable& trials) const;
  /// Trials that the finished experiment has: exact once it is finished or without a stopping rule,
  /// otherwise the most that may come.
  [[nodiscard]] std::int64_t expected(const TrialTable& trials) const;
  /// 95 % interval of a cell's rate: Wilson's or, under a stopping rule, the rule's.
  [[nodiscard]] Interval interval(const Proportion& proportion) const;

 private:
  const Experiment& experiment_;
  std::optional<SequentialPlan> plan_;
};

}  // namespace binpick
