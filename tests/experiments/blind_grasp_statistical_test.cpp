// Guards the blind grasps of Table 1: impedance control, contact physics, grip, collision reaction.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "experiments/blind_grasp_trial.h"
#include "experiments/success_gate.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

/// Runs trials of Table 1's nine stiffness pairs in turn until a gate on their common rate has its
/// verdict.
void expect_rate(const std::string& reaction, double expected) {
  BlindGraspTrial kind;
  SuccessGate gate(expected);
  std::string failures;
  const auto trial_of = [](std::int64_t i) {
    return TrialContext{TrialSeeds(4711, "gate", "cell", i), i, {}, {}, {}};
  };
  for (std::int64_t i = 0; gate.verdict() == SuccessGate::Verdict::kOpen; ++i) {
    constexpr double kTranslation[] = {200, 750, 2000};
    constexpr double kRotation[] = {20, 75, 200};
    read_yaml_text(fmt::format("scene: blind_bottle.yaml\ngrasp: top across wide axis\n"
                               "stiffness: {{translation_y: {}, rotation_x: {}}}\nreaction: {}\n",
                               kTranslation[i % 3], kRotation[i / 3 % 3], reaction),
                   "test", [&](ConfigVisitor& visitor) { kind.visit(visitor); });
    kind.prepare(BINPICK_SOURCE_DIR "/scenes");
    const TrialRecord record = kind.run(trial_of(i));
    gate.add(record.outcome == TrialOutcome::kSuccess);
    if (record.outcome != TrialOutcome::kSuccess) {
      failures +=
          fmt::format("trial {}: {} at {}\n", i, to_text(record.outcome), to_text(record.stage));
    }
  }
  EXPECT_EQ(gate.verdict(), SuccessGate::Verdict::kPassed)
      << gate.seen().successes << " of " << gate.seen().trials << "\n"
      << failures;
}

// Expected: a little less than `binpick run experiments/table1.yaml` finds: 90/90 without reaction,
// and with it 384/540 at --trials 60. (Its ten trials a cell share ten pose errors over all cells:
// their 75/90 say less than ninety trials would.)
TEST(BlindGrasp, TheBottleIsHeldInTheEnd) { expect_rate("false", 0.95); }

TEST(BlindGrasp, CollisionsAreAsRareAsTheyWere) { expect_rate("true", 0.70); }

}  // namespace
}  // namespace binpick
