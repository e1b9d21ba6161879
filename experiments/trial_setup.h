#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiments/trial_kind.h"
#include "models/object_model.h"
#include "sim/physics_draw.h"

namespace binpick {

/// The masses and frictions of a trial: `mode` "drawn" draws them from the models' ranges, the same
/// in all cells; "centre" holds them at their centres.
[[nodiscard]] PhysicsDraw physics_of_trial(const std::vector<ObjectModel>& objects,
                                           const std::string& mode, const TrialContext& context);

/// The files that decide a trial in the scene `scene_file`: the scene with what it extends, and the
/// descriptions and meshes of arm, gripper and objects. Sorted.
/// @throws InputError when the scene cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> trial_input_files(
    const std::filesystem::path& scene_file);

/// Runs `body`, which fills `record`. A diverged simulation, a safety stop or a spent time
/// budget becomes the record's outcome, at the stage that `body` entered last through the context
/// it is given.
void run_in_simulation(const TrialContext& context, TrialRecord& record,
                       const std::function<void(const TrialContext&)>& body);

/// Makes `record` a failure.
void fail(TrialRecord& record, TrialOutcome outcome, TrialStage stage, std::string note = {});

}  // namespace binpick
