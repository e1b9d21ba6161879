#pragma once

#include <CLI/CLI.hpp>

namespace binpick {

/// `binpick doctor`: checks what a run needs from this machine, one line each. Exit code 1 when
/// something that runs depend on is missing.
void add_doctor_command(CLI::App& app, int& exit_code);

}  // namespace binpick
