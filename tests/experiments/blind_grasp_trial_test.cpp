#include "experiments/blind_grasp_trial.h"

#include <gtest/gtest.h>

#include "models/errors.h"
#include "models/yaml_config.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

constexpr const char* kScenes = BINPICK_SOURCE_DIR "/scenes";

BlindGraspTrial make_trial(const std::string& more = "") {
  BlindGraspTrial trial;
  read_yaml_text("scene: blind_bottle.yaml\ngrasp: top across wide axis\n" + more, "test",
                 [&](ConfigVisitor& visitor) { trial.visit(visitor); });
  trial.prepare(kScenes);
  return trial;
}

TrialContext context_of(std::int64_t trial) {
  return {TrialSeeds(2012, "table1", "cell", trial), trial, {}, {}, {}};
}

TEST(BlindGraspTrial, GraspsTheBottleWhereItIsBelieved) {
  const TrialRecord record = make_trial("pose_error: 0\n").run(context_of(0));
  EXPECT_EQ(record.outcome, TrialOutcome::kSuccess) << record.note;
  EXPECT_NEAR(record.measures.at("jaw_width_m"), 0.103, 0.003);
}

TEST(BlindGraspTrial, FailsWhenTheBottleIsFarFromWhereItIsBelieved) {
  const TrialRecord record = make_trial("pose_error: 0.2\n").run(context_of(0));
  EXPECT_EQ(record.outcome, TrialOutcome::kFailedGrasp);
  EXPECT_EQ(record.stage, TrialStage::kGrasp);
}

TEST(BlindGraspTrial, EndsAtACollisionOnlyWhenTheReactionIsOn) {
  // Trial 4 strikes the bottle's shoulder (15.7 N by the estimate with the reaction on).
  const TrialRecord on = make_trial("collision_force: 10\n").run(context_of(4));
  EXPECT_EQ(on.outcome, TrialOutcome::kCollisionAbort);
  EXPECT_EQ(on.stage, TrialStage::kApproach);
  const TrialRecord off = make_trial("collision_force: 10\nreaction: off\n").run(context_of(4));
  EXPECT_NE(off.outcome, TrialOutcome::kCollisionAbort);
  EXPECT_GT(off.measures.at("peak_force_n"), 10.0);
}

TEST(BlindGraspTrial, TheGraspCanBeTurnedAndRaised) {
  const auto width_with = [](const std::string& change) {
    const TrialRecord record = make_trial("pose_error: 0\n" + change).run(context_of(0));
    EXPECT_EQ(record.outcome, TrialOutcome::kSuccess) << change << record.note;
    return record.measures.at("jaw_width_m");
  };
  // From the bottle's wide axis to its narrow one. The belt is as wide over a pad's height.
  EXPECT_NEAR(width_with("grasp_turn_deg: 90\n"), 0.070, 0.004);
  EXPECT_NE(width_with("grasp_raise: 0.015\n"), width_with(""));
}

TEST(BlindGraspTrial, TheOtherProtocolsStartFromFeasibleGrasps) {
  const std::pair<const char*, const char*> protocols[] = {
      {"blind_bottle_narrow.yaml", "top across narrow axis"},
      {"blind_bottle_lying.yaml", "side across wide axis at the waist"},
      {"blind_bottle_lying.yaml", "side across wide axis below the belt"}};
  for (const auto& [scene, grasp] : protocols) {
    BlindGraspTrial trial;
    read_yaml_text(std::string("pose_error: 0\nscene: ") + scene + "\ngrasp: " + grasp + "\n",
                   "test", [&](ConfigVisitor& visitor) { trial.visit(visitor); });
    trial.prepare(kScenes);
    EXPECT_EQ(trial.run(context_of(0)).outcome, TrialOutcome::kSuccess) << grasp;
  }
}

TEST(BlindGraspTrial, FixedPhysicsTakesThePlaceOfTheDraw) {
  const auto outcome_with = [](const char* friction) {
    return make_trial(
               std::string("pose_error: 0\ngrip_force: 5\nfixed: {mass: 0.6, pad_friction: ") +
               friction + "}\n")
        .run(context_of(0))
        .outcome;
  };
  // 2 x 5 N: 0.6 kg weigh 5.9 N.
  EXPECT_EQ(outcome_with("0.9"), TrialOutcome::kSuccess);
  EXPECT_NE(outcome_with("0.3"), TrialOutcome::kSuccess);
}

TEST(BlindGraspTrial, OffsetsAreDrawnAndLeaveTheOtherDrawsAlone) {
  const TrialRecord exact = make_trial().run(context_of(1));
  for (const char* offset : {"joint_offset_deg: 0.1\n", "opening_tolerance: 0.001\n"}) {
    const TrialRecord record = make_trial(offset).run(context_of(1));
    EXPECT_NE(record.measures.at("peak_force_n"), exact.measures.at("peak_force_n")) << offset;
    EXPECT_EQ(record.measures.at("error_direction_rad"), exact.measures.at("error_direction_rad"))
        << offset;
  }
  // Zeros wrong by degrees move the hand by centimetres.
  EXPECT_NE(make_trial("pose_error: 0\ncollision_force: 5\njoint_offset_deg: 5\n")
                .run(context_of(0))
                .outcome,
            TrialOutcome::kSuccess);
}

TEST(BlindGraspTrial, ANarrowerOpeningStrikesMoreOften) {
  const auto collisions_with = [](const char* opening) {
    BlindGraspTrial trial = make_trial(std::string("pre_opening: ") + opening + "\n");
    int collisions = 0;
    for (std::int64_t i = 0; i < 6; ++i) {
      collisions += trial.run(context_of(i)).outcome == TrialOutcome::kCollisionAbort ? 1 : 0;
    }
    return collisions;
  };
  EXPECT_GT(collisions_with("0.105"), collisions_with("0.140"));
}

TEST(BlindGraspTrial, SameSeedsGiveTheSameBits) {
  BlindGraspTrial trial = make_trial();
  const TrialRecord first = trial.run(context_of(1));
  (void)trial.run(context_of(2));
  EXPECT_TRUE(identical(first, trial.run(context_of(1))));
  EXPECT_TRUE(identical(first, make_trial().run(context_of(1))));
}

TEST(BlindGraspTrial, RecordingChangesNothing) {
  const TemporaryFolder folder;
  BlindGraspTrial trial = make_trial();
  TrialContext recorded = context_of(1);
  recorded.trace = folder.path();
  EXPECT_TRUE(identical(trial.run(context_of(1)), trial.run(recorded)));
  EXPECT_GT(std::filesystem::file_size(folder.path() / "trace.csv"), 1000u);
}

TEST(BlindGraspTrial, AnUnknownGraspIsAnInputError) {
  BlindGraspTrial trial;
  read_yaml_text("scene: blind_bottle.yaml\ngrasp: by the ears\n", "test",
                 [&](ConfigVisitor& visitor) { trial.visit(visitor); });
  EXPECT_THROW(trial.prepare(kScenes), InputError);
}

}  // namespace
}  // namespace binpick
