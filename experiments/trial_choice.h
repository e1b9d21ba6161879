#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace binpick {

/// One trial of an experiment, as a command line names it.
struct TrialChoice {
  std::string cell = "all";  ///< the cell's key; that of the only cell unless said otherwise
  std::int64_t trial = 0;
};

/// Adds `--cell` and `--trial` to a command; `choice` must outlive it.
void add_trial_choice(CLI::App& command, TrialChoice& choice);

}  // namespace binpick
