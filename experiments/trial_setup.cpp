#include "experiments/trial_setup.h"

#include <algorithm>

#include "scenes/scene.h"
#include "sim/simulation_error.h"

namespace binpick {

PhysicsDraw physics_of_trial(const std::vector<ObjectModel>& objects, const std::string& mode,
                             const TrialContext& context) {
  if (mode == "centre") return centre_physics(objects);
  return draw_physics(objects, context.seeds.shared("physics"));
}

std::vector<std::filesystem::path> trial_input_files(const std::filesystem::path& scene_file) {
  std::vector<std::filesystem::path> files = scene_files(scene_file);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(models_directory())) {
    const std::string extension = entry.path().extension();
    if (extension == ".yaml" || extension == ".obj" || extension == ".urdf") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

void run_in_simulation(const TrialContext& context, TrialRecord& record,
                       const std::function<void(const TrialContext&)>& body) {
  const StageWatch watch(context);
  try {
    body(watch.context());
  } catch (const SimulationDiverged& diverged) {
    fail(record, TrialOutcome::kDiverged, watch.stage(), diverged.what());
  } catch (const RobotStopped& stopped) {
    fail(record, TrialOutcome::kSafetyStop, watch.stage(), stopped.what());
  } catch (const TimeBudgetSpent& spent) {
    fail(record, TrialOutcome::kTimeout, watch.stage(), spent.what());
  }
}

void fail(TrialRecord& record, TrialOutcome outcome, TrialStage stage, std::string note) {
  record.outcome = outcome;
  record.stage = stage;
  record.note = std::move(note);
}

}  // namespace binpick
