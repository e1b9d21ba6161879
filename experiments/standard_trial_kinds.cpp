#include "experiments/standard_trial_kinds.h"

namespace binpick {

TrialKindRegistry standard_trial_kinds() {
  TrialKindRegistry registry;
  return registry;
}

}  // namespace binpick
