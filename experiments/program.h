#pragma once

#include "experiments/trial_kind.h"

namespace binpick {

/// The program: parses the command line, runs the command and maps failures to exit codes:
/// 0 ok, 1 a gate failed or results differ, 2 usage, configuration or input, 3 reading or writing,
/// 4 internal, 130 and 143 after SIGINT and SIGTERM.
[[nodiscard]] int program_main(int argc, char** argv, const TrialKindRegistry& registry);

}  // namespace binpick
