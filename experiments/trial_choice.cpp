#include "experiments/trial_choice.h"

namespace binpick {

void add_trial_choice(CLI::App& command, TrialChoice& choice) {
  command.add_option("--cell", choice.cell, "axis=value,axis=value")->capture_default_str();
  command.add_option("--trial", choice.trial, "number, from 0")
      ->check(CLI::NonNegativeNumber)
      ->required();
}

}  // namespace binpick
