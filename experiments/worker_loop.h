#pragma once

#include "experiments/trial_kind.h"

namespace binpick {

/// The life of a worker process: reads orders from kWorkerOrders, runs trials one after the other
/// and answers on kWorkerReplies until the orders end or a trial leaves the process unusable.
/// @return the process's exit code.
int run_worker_loop(const TrialKindRegistry& registry);

}  // namespace binpick
