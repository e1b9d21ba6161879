#include "experiments/doctor_command.h"
#include "experiments/program.h"
#include "experiments/recognize_command.h"
#include "experiments/render_command.h"
#include "experiments/standard_trial_kinds.h"

int main(int argc, char** argv) {
  return binpick::program_main(
      argc, argv, binpick::standard_trial_kinds(),
      {binpick::add_recognize_command, binpick::add_render_command, binpick::add_doctor_command});
}
