#include "experiments/cleanup_trial.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/trial_setup.h"
#include "sim/pile.h"

namespace binpick {
namespace {

void count_attempts(const VisionLoopResult& result, TrialRecord& record) {
  int correct = 0;
  int collisions = 0;
  int failed_grasps = 0;
  int lost = 0;
  for (const GraspAttempt& attempt : result.attempts) {
    if (attempt.match && attempt.match->correct()) ++correct;
    if (attempt.grasp == SkillResult::kCollision) ++collisions;
    if (attempt.grasp == SkillResult::kFailedGrasp) ++failed_grasps;
    if (attempt.carry != SkillResult::kDone || attempt.place != SkillResult::kDone) ++lost;
  }
  record.measures["attempts"] = static_cast<double>(result.attempts.size());
  record.measures["attempts_correct_pose"] = correct;
  record.measures["collisions"] = collisions;
  record.measures["failed_grasps"] = failed_grasps;
  record.measures["lost_on_the_way"] = lost;
  record.measures["placed_by_belief"] = result.automaton.placed;
}

std::string list_objects(const World& world, const std::vector<int>& objects) {
  std::string text;
  for (const int object : objects) {
    const Eigen::Vector3d p_world = world.object_pose(object).translation();
    text += fmt::format("{}{} at ({:.2f}, {:.2f}, {:.2f})", text.empty() ? "" : ", ",
                        world.object_model(object).name, p_world.x(), p_world.y(), p_world.z());
  }
  return text;
}

/// The outcome of a run that left objects behind: what the robot was missing them by.
void explain_failure(const World& world, const Referee& referee, const VisionLoopResult& result,
                     const std::vector<int>& misplaced, TrialRecord& record) {
  record.note = "not in place: " + list_objects(world, misplaced);
  const std::vector<int> in_sight = referee.objects_in_pick_region();
  if (result.automaton.reason == HaltReason::kGaveUp) {
    const AutomatonState last = result.automaton.events.back().state;
    record.outcome = TrialOutcome::kTimeout;
    record.stage =
        last == AutomatonState::kSelectGrasp ? TrialStage::kSelect : TrialStage::kRecognize;
    record.note += "; no progress for too long";
  } else if (!in_sight.empty()) {
    record.outcome = TrialOutcome::kNothingDetected;
    record.stage = TrialStage::kRecognize;
  } else {
    record.outcome = TrialOutcome::kDropped;
    record.stage = TrialStage::kCarry;
  }
}

}  // namespace

void CleanupTrial::visit(ConfigVisitor& visitor) {
  visitor.text("scene", scene_, Presence::kRequired);
  visitor.integer("looks_before_empty", looks_before_empty_, 1, 100);
  visitor.integer("max_idle_cycles", max_idle_cycles_, 1, 1000);
  visitor.group("loop", [&](ConfigVisitor& group) { loop_.visit(group); });
}

std::vector<std::filesystem::path> CleanupTrial::input_files(
    const std::filesystem::path& config_directory) const {
  return trial_input_files(config_directory / scene_);
}

void CleanupTrial::prepare(const std::filesystem::path& config_directory) {
  const std::filesystem::path file = config_directory / scene_;
  const std::string wanted = file.string() + '\n' + loop_.recognizer;
  if (loaded_ == wanted) return;
  cell_ = std::make_unique<VisionCell>(file, loop_.recognizer_options());
  loaded_ = wanted;
}

TrialRecord CleanupTrial::run(const TrialContext& context) {
  TrialRecord record;
  VisionLoopResult result;
  run_in_simulation(context, record,
                    [&](const TrialContext& observed) { clean_up(observed, record, result); });
  count_attempts(result, record);
  return record;
}

void CleanupTrial::clean_up(const TrialContext& context, TrialRecord& record,
                            VisionLoopResult& result) const {
  context.enter(TrialStage::kSetup);
  World world(cell_->world, physics_of_trial(cell_->world->parts.objects, loop_.physics, context),
              loop_.plant.drives());
  const PileReport pile = drop_pile(world, context.seeds.shared("pile"));
  record.measures["pile_attempts"] = pile.attempts;
  if (!pile.settled) {
    return fail(record, TrialOutcome::kTimeout, TrialStage::kSetup,
                "the pile did not come to rest");
  }
  AutomatonOptions automaton;
  automaton.looks_before_empty = static_cast<int>(looks_before_empty_);
  automaton.max_idle_cycles = static_cast<int>(max_idle_cycles_);
  run_vision_loop(*cell_, world, loop_, automaton, context, result);

  context.enter(TrialStage::kJudge);
  const Referee referee(world);
  const std::vector<int> misplaced = referee.misplaced_objects();
  record.measures["in_place"] = world.object_count() - static_cast<double>(misplaced.size());
  record.measures["simulated_time_s"] = world.time();
  if (!misplaced.empty()) {
    explain_failure(world, referee, result, misplaced, record);
  } else if (result.automaton.reason == HaltReason::kGaveUp) {
    fail(record, TrialOutcome::kTimeout, TrialStage::kRecognize,
         "everything in place, but the robot did not believe the table empty");
  }
}

}  // namespace binpick
