// Guards the closed loop: rendered depth, recognition, selection, impedance, placing.

#include <gtest/gtest.h>

#include "experiments/proportions.h"
#include "experiments/vision_grasp_trial.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

constexpr const char* kScenes = BINPICK_SOURCE_DIR "/scenes";
constexpr const char* kSubjects =
    "pile_scene: pile.yaml\n"
    "subjects:\n"
    "  - {model: bottle, single_scene: single_bottle.yaml}\n"
    "  - {model: amicelli, single_scene: single_amicelli.yaml}\n"
    "  - {model: rusk, single_scene: single_rusk.yaml, restings: [upright, x_up, y_up]}\n";

TrialContext context_of(std::int64_t trial) {
  return {TrialSeeds(4711, "gate", "cell", trial), trial, {}, {}, {}};
}

/// Runs trials of every object in one scenario; fails when the rate is below `minimum` beyond
/// doubt.
void expect_rate(const std::string& scenario, int trials_per_object, double minimum) {
  std::int64_t successes = 0;
  std::int64_t trials = 0;
  std::string failures;
  VisionGraspTrial kind;
  for (const char* object : {"bottle", "amicelli", "rusk"}) {
    read_yaml_text(
        kSubjects + ("object: " + std::string(object)) + "\nscenario: " + scenario + "\n", "test",
        [&](ConfigVisitor& visitor) { kind.visit(visitor); });
    kind.prepare(kScenes);
    for (int trial = 0; trial < trials_per_object; ++trial) {
      const TrialRecord record = kind.run(context_of(trial));
      ++trials;
      if (record.outcome == TrialOutcome::kSuccess) {
        ++successes;
      } else {
        failures += std::string(object) + " " + std::to_string(trial) + ": " +
                    std::string(to_text(record.outcome)) + ", " + record.note + "\n";
      }
    }
  }
  EXPECT_GE(wilson_interval({successes, trials}).high, minimum)
      << successes << " of " << trials << "\n"
      << failures;
}

TEST(VisionGrasp, SingleObjectsReachTheirPlaces) { expect_rate("single", 4, 0.95); }

TEST(VisionGrasp, ObjectsOfAPileReachTheirPlaces) { expect_rate("pile", 2, 0.90); }

TEST(VisionGrasp, TheSameSeedsGiveTheSameBitsOnAFreshAndOnAUsedInstance) {
  const auto prepared = [] {
    auto kind = std::make_unique<VisionGraspTrial>();
    read_yaml_text(std::string(kSubjects) + "object: rusk\n", "test",
                   [&](ConfigVisitor& visitor) { kind->visit(visitor); });
    kind->prepare(kScenes);
    return kind;
  };
  const auto used = prepared();
  (void)used->run(context_of(1));
  EXPECT_TRUE(identical(used->run(context_of(0)), prepared()->run(context_of(0))));
}

}  // namespace
}  // namespace binpick
