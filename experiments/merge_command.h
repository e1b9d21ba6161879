#pragma once

#include <CLI/CLI.hpp>

#include "experiments/trial_kind.h"

namespace binpick {

/// `binpick merge OUT IN...`: joins the results of shards, in any order, into one store.
void add_merge_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code);

}  // namespace binpick
