#pragma once

#include <mujoco/mujoco.h>

#include <memory>

namespace binpick {

struct MjModelDeleter {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
struct MjDataDeleter {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};

using MjModelPtr = std::unique_ptr<mjModel, MjModelDeleter>;
using MjDataPtr = std::unique_ptr<mjData, MjDataDeleter>;

/// Makes MuJoCo's errors throw SimulationDiverged instead of ending the process, and keeps it from
/// writing MUJOCO_LOG.TXT. Idempotent and thread-safe; every entrance of this room calls it.
void install_mujoco_handlers();

/// The text of this thread's last MuJoCo warning.
[[nodiscard]] const char* last_mujoco_warning() noexcept;

}  // namespace binpick
