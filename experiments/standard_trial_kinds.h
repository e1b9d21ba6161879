#pragma once

#include "experiments/trial_kind.h"

namespace binpick {

/// The trial kinds of the binpick program.
[[nodiscard]] TrialKindRegistry standard_trial_kinds();

}  // namespace binpick
