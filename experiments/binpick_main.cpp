#include "experiments/program.h"
#include "experiments/standard_trial_kinds.h"

int main(int argc, char** argv) {
  return binpick::program_main(argc, argv, binpick::standard_trial_kinds());
}
