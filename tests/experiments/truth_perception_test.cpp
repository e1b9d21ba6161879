// The oracle: exact, but not clairvoyant; and chosen only by name.

#include "experiments/truth_perception.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "experiments/vision_loop.h"
#include "models/yaml_config.h"
#include "vision_cell_support.h"

namespace binpick {
namespace {

using testing::scene_with;
using testing::standing;
using testing::VisionBench;

TEST(TruthPerception, GivesTheTruePosesOfWhatTheCameraSees) {
  VisionBench bench(scene_with({standing("bottle", 0.55, 0.1), standing("rusk", 0.55, -0.12)}),
                    {"bottle", "rusk"});
  SimulatedRobot robot(bench.world, &bench.camera, {});
  TruthPerception oracle(bench.world);
  const std::vector<Detection> detections = oracle.recognize(robot.capture());
  ASSERT_EQ(detections.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Detection& detection = detections[static_cast<std::size_t>(i)];
    EXPECT_EQ(detection.model, bench.world.object_model(i).name);
    EXPECT_TRUE(detection.T_scene_model.isApprox(bench.world.object_pose(i), 0.0));
    EXPECT_GT(detection.visibility, 0.6);
  }
}

TEST(TruthPerception, DoesNotSeeWhatIsHiddenOrWasNotThereWhenTheImageWasTaken) {
  VisionBench bench(scene_with({standing("bottle", 0.55, 0.1), standing("rusk", 0.55, -0.12)}),
                    {"bottle", "rusk"});
  SimulatedRobot robot(bench.world, &bench.camera, {});
  TruthPerception oracle(bench.world);
  const RangeImage image = robot.capture();
  bench.world.set_object_pose(0, Eigen::Translation3d(0.0, 0.15, 0.0) * bench.world.object_pose(0));
  const std::vector<Detection> detections = oracle.recognize(image);
  ASSERT_EQ(detections.size(), 1u);
  EXPECT_EQ(detections.front().model, "rusk");
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(TruthPerception, OnlyConfigurationsCalledPerfectUseItAndSaySoInTheirTitle) {
  int perfect = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BINPICK_SOURCE_DIR "/experiments")) {
    if (entry.path().extension() != ".yaml") continue;
    const std::string text = text_of(entry.path());
    const bool named = entry.path().stem().string().ends_with("_perfect");
    EXPECT_EQ(text.find("perception: truth") != std::string::npos, named) << entry.path();
    if (!named) continue;
    ++perfect;
    EXPECT_THAT(text, ::testing::HasSubstr("with perfect perception: poses are the truth"));
  }
  EXPECT_EQ(perfect, 2);
  EXPECT_EQ(VisionLoopParameters{}.perception, "camera");
}

TEST(TruthPerception, MarksTheRecord) {
  VisionLoopParameters parameters;
  TrialRecord record;
  mark_oracle(parameters, record);
  EXPECT_TRUE(record.measures.empty());
  parameters.perception = "truth";
  mark_oracle(parameters, record);
  EXPECT_EQ(record.measures.at("oracle_perception"), 1.0);
}

VisionLoopParameters parameters_from(const std::string& yaml) {
  VisionLoopParameters parameters;
  read_yaml_text(yaml, "test", [&](ConfigVisitor& visitor) { parameters.visit(visitor); });
  return parameters;
}

TEST(VisionLoopParameters, TheSettingPresetsThePiecesAndEachCanBeChosen) {
  EXPECT_FALSE(parameters_from("setting: paper").strategy.search);
  EXPECT_TRUE(parameters_from("setting: best").strategy.search);
  const auto without = parameters_from("setting: best\nstrategy: {search: false}");
  EXPECT_FALSE(without.strategy.search);
  EXPECT_TRUE(without.strategy.verification);
  const auto alone = parameters_from("strategy: {search: true}");
  EXPECT_TRUE(alone.strategy.search);
  EXPECT_FALSE(alone.strategy.verification);
}

TEST(VisionLoopParameters, TheEffectiveConfigurationReadsBackAsItWas) {
  VisionLoopParameters parameters = parameters_from("setting: best\nstrategy: {regrasp: false}");
  const auto written = write_yaml([&](ConfigVisitor& visitor) { parameters.visit(visitor); });
  const VisionLoopParameters again = parameters_from(written);
  EXPECT_FALSE(again.strategy.regrasp);
  EXPECT_TRUE(again.strategy.steep_grasps);
}

GraspAttempt attempt(SkillResult grasp, SkillResult carry = SkillResult::kDone,
                     SkillResult place = SkillResult::kDone) {
  GraspAttempt attempt;
  attempt.grasp = grasp;
  attempt.carry = carry;
  attempt.place = place;
  return attempt;
}

TEST(AttemptEnd, BooksEveryFailureWhereItHappened) {
  using enum SkillResult;
  const auto expect = [](const GraspAttempt& failed, TrialOutcome outcome, TrialStage stage) {
    const AttemptEnd end = end_of(failed);
    EXPECT_EQ(end.outcome, outcome);
    EXPECT_EQ(end.stage, stage);
  };
  expect(attempt(kDone), TrialOutcome::kSuccess, TrialStage::kJudge);
  expect(attempt(kUnreachable), TrialOutcome::kUnreachable, TrialStage::kApproach);
  expect(attempt(kCollision), TrialOutcome::kCollisionAbort, TrialStage::kApproach);
  expect(attempt(kFailedGrasp), TrialOutcome::kFailedGrasp, TrialStage::kGrasp);
  expect(attempt(kLoadedCollision), TrialOutcome::kCollisionAbort, TrialStage::kGrasp);
  expect(attempt(kSlipped), TrialOutcome::kSlipped, TrialStage::kGrasp);
  expect(attempt(kDone, kSlipped), TrialOutcome::kSlipped, TrialStage::kCarry);
  expect(attempt(kDone, kLoadedCollision), TrialOutcome::kCollisionAbort, TrialStage::kCarry);
  expect(attempt(kDone, kDone, kSlipped), TrialOutcome::kSlipped, TrialStage::kPlace);
}

}  // namespace
}  // namespace binpick
