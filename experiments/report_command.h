#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// `binpick report DIR...`: writes report and exports of results folders anew, with pictures and
/// replays of single trials, which are run again for it.
void add_report_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
