#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// `binpick report DIR`: prints the table of a results folder and writes report and exports anew.
void add_report_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
