#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <vector>

#include "experiments/trial_kind.h"

namespace binpick {

/// Adds a subcommand that leaves its exit code in the second argument.
using AddCommand = std::function<void(CLI::App&, int&)>;

/// The program: the commands that deal with experiments of the registry's kinds, and `more`. Parses
/// the command line, runs the command and maps failures to exit codes: 0 ok, 1 a gate failed or
/// results differ, 2 usage, configuration or input, 3 reading or writing, 4 internal, 130 and 143
/// after SIGINT and SIGTERM.
[[nodiscard]] int program_main(int argc, char** argv, const TrialKindRegistry& registry,
                               const std::vector<AddCommand>& more = {});

}  // namespace binpick
