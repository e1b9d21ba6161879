#include "sim/mujoco_handles.h"

#include <mutex>
#include <string>

#include "sim/simulation_error.h"

namespace binpick {
namespace {

thread_local std::string last_warning;

void throw_error(const char* message) {
  throw SimulationDiverged(std::string("MuJoCo: ") + message);
}

void keep_warning(const char* message) { last_warning = message; }

}  // namespace

void install_mujoco_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = throw_error;
    mju_user_warning = keep_warning;
  });
}

const char* last_mujoco_warning() noexcept { return last_warning.c_str(); }

}  // namespace binpick
