#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// `binpick status DIR`: how far a run is, whether it is going on, and what it has shown so far.
void add_status_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
