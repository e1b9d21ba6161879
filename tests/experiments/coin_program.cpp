#include "coin_trial.h"
#include "experiments/program.h"

// The program with one trial kind, for tests that need processes.
int main(int argc, char** argv) {
  binpick::TrialKindRegistry registry;
  registry.add("coin", [] { return std::make_unique<binpick::CoinTrial>(); });
  return binpick::program_main(argc, argv, registry);
}
