#include "experiments/cleanup_trial.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/trial_setup.h"
#include "sim/pile.h"

namespace binpick {
namespace {

/// How many attempts ended how: the failures from which the robot recovered, too.
void count_attempts(const VisionLoopResult& result, TrialRecord& record) {
  std::map<std::string, double>& measures = record.measures;
  measures["attempts"] = static_cast<double>(result.attempts.size());
  measures["pushes"] = result.pushes;
  measures["placed_by_belief"] = result.automaton.placed;
  for (const char* name : {"attempts_correct_pose", "unreachable", "approach_collisions",
                           "empty_grasps", "loaded_collisions", "slips"}) {
    measures[name] = 0.0;
  }
  for (const GraspAttempt& attempt : result.attempts) {
    if (attempt.match && attempt.match->correct()) ++measures["attempts_correct_pose"];
    const AttemptEnd end = end_of(attempt);
    if (end.outcome == TrialOutcome::kUnreachable) ++measures["unreachable"];
    if (end.outcome == TrialOutcome::kFailedGrasp) ++measures["empty_grasps"];
    if (end.outcome == TrialOutcome::kSlipped) ++measures["slips"];
    if (end.outcome == TrialOutcome::kCollisionAbort) {
      ++measures[end.stage == TrialStage::kApproach ? "approach_collisions" : "loaded_collisions"];
    }
  }
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

/// How the last attempt to grasp one of `objects` ended. Set down for good and yet not in place:
/// dropped. Never tried: dropped before, by the robot's other doings.
AttemptEnd last_end(const VisionLoopResult& result, const std::vector<int>& objects) {
  const auto last = std::find_if(
      result.attempts.rbegin(), result.attempts.rend(), [&](const GraspAttempt& attempt) {
        return attempt.match &&
               std::find(objects.begin(), objects.end(), attempt.match->object) != objects.end();
      });
  if (last == result.attempts.rend()) return {TrialOutcome::kDropped, TrialStage::kJudge};
  if (last->done()) return {TrialOutcome::kDropped, TrialStage::kPlace};
  return end_of(*last);
}

/// The outcome of a run that left objects behind: what the robot was missing them by.
void explain_failure(const World& world, const Referee& referee, const VisionLoopResult& result,
                     const std::vector<int>& misplaced, TrialRecord& record) {
  const std::vector<int> in_sight = referee.objects_in_pick_region();
  AttemptEnd end = last_end(result, misplaced);
  std::string note = "not in place: " + list_objects(world, misplaced);
  if (result.automaton.reason == HaltReason::kGaveUp) {
    // It gives up after a look: what did that show?
    const bool graspless = !result.automaton.events.back().conditions.no_object;
    end = {TrialOutcome::kTimeout, graspless ? TrialStage::kSelect : TrialStage::kRecognize};
    note += "; no progress for too long";
  } else if (!in_sight.empty()) {
    end = {TrialOutcome::kNothingDetected, TrialStage::kRecognize};
  }
  fail(record, end.outcome, end.stage, std::move(note));
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
  const std::string wanted = file.string() + '\n' + loop_.cell_key();
  if (loaded_ == wanted) return;
  cell_ = std::make_unique<VisionCell>(file, loop_);
  loaded_ = wanted;
}

TrialRecord CleanupTrial::run(const TrialContext& context) {
  TrialRecord record;
  VisionLoopResult result;
  run_in_simulation(context, record,
                    [&](const TrialContext& observed) { clean_up(observed, record, result); });
  count_attempts(result, record);
  mark_oracle(loop_, record);
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
