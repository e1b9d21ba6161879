#include "experiments/standard_trial_kinds.h"

#include "experiments/blind_grasp_trial.h"
#include "experiments/cleanup_trial.h"
#include "experiments/contact_trial.h"
#include "experiments/recognition_trial.h"
#include "experiments/vision_grasp_trial.h"

namespace binpick {

TrialKindRegistry standard_trial_kinds() {
  TrialKindRegistry registry;
  registry.add("blind_grasp", [] { return std::make_unique<BlindGraspTrial>(); });
  registry.add("vision_grasp", [] { return std::make_unique<VisionGraspTrial>(); });
  registry.add("contact", [] { return std::make_unique<ContactTrial>(); });
  registry.add("cleanup", [] { return std::make_unique<CleanupTrial>(); });
  registry.add("recognition", [] { return std::make_unique<RecognitionTrial>(); });
  return registry;
}

}  // namespace binpick
