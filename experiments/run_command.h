#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// `binpick run CONFIG`: runs the trials that are missing, prints the table, writes the report.
void add_run_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
