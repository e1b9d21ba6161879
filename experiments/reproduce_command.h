#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// `binpick reproduce DIR|CONFIG --cell KEY --trial N`: runs one trial again, in this process, and
/// compares its record with the stored one bit for bit.
void add_reproduce_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
