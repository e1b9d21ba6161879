#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// Adds `binpick view DIR --cell KEY --trial N`: one trial of a run as a page with its pictures and
/// its 3-D replay, which opens in the browser where there is a display.
void add_view_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
