#pragma once

#include <functional>

#include "experiments/experiment.h"
#include "experiments/trial_kind.h"

namespace binpick {

/// A record and whether the instance that made it can go on. After an exception it cannot: what it
/// left behind is unknown.
struct TrialRun {
  TrialRecord record;
  bool kind_usable = true;
};

/// Runs one trial of a kind whose parameters are set and prepared. Whatever `run` throws becomes a
/// record with outcome kCrashed at the stage last entered.
[[nodiscard]] TrialRun run_trial(TrialKind& kind, const TrialContext& context);

/// Makes the kind, sets the cell's parameters, prepares and runs: one trial on its own.
/// @throws InputError from preparation.
[[nodiscard]] TrialRecord run_single_trial(const Experiment& experiment, const Cell& cell,
                                           const TrialContext& context);

}  // namespace binpick
