#include "experiments/vision_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "experiments/trial_recorder.h"
#include "experiments/truth_perception.h"
#include "sim/simulated_robot.h"

namespace binpick {
namespace {

TrialStage stage_of(AutomatonState state) {
  switch (state) {
    case AutomatonState::kGoToOverview:
      return TrialStage::kOverview;
    case AutomatonState::kRecognizeObjects:
      return TrialStage::kRecognize;
    case AutomatonState::kSelectGrasp:
      return TrialStage::kSelect;
    case AutomatonState::kGraspObject:
      return TrialStage::kGrasp;
    case AutomatonState::kCarryAway:
      return TrialStage::kCarry;
    case AutomatonState::kPlaceDown:
      return TrialStage::kPlace;
    case AutomatonState::kRearrange:
      return TrialStage::kSelect;
    case AutomatonState::kHalted:
      break;
  }
  return TrialStage::kJudge;
}

/// Hands every skill on and notes, beside the robot's plans, what the referee knows of them.
class ObservedSkills final : public ManipulationSkills {
 public:
  ObservedSkills(ManipulationSkills& skills, const Referee& referee, VisionLoopResult& result)
      : skills_(skills), referee_(referee), attempts_(result.attempts), pushes_(result.pushes) {}

  void go_to_overview() override { skills_.go_to_overview(); }
  std::vector<Detection> recognize() override { return skills_.recognize(); }
  int obstruction(const GraspPlan& plan) override { return skills_.obstruction(plan); }
  double hidden_share(const GraspPlan& plan) override { return skills_.hidden_share(plan); }
  bool has_way(const GraspPlan& plan, const Place& place, const Eigen::Vector2d& slot) override {
    return skills_.has_way(plan, place, slot);
  }
  std::vector<Eigen::Vector3d> unrecognized_surface() override {
    return skills_.unrecognized_surface();
  }
  SkillResult push(const std::vector<Eigen::Vector3d>& surface) override {
    const SkillResult result = skills_.push(surface);
    if (result != SkillResult::kUnreachable) ++pushes_;
    return result;
  }
  SkillResult grasp(const GraspPlan& plan) override {
    attempts_.push_back({plan, referee_.match(plan.detection)});
    return attempts_.back().grasp = skills_.grasp(plan);
  }
  SkillResult carry(const GraspPlan& plan, const Place& place,
                    const Eigen::Vector2d& slot) override {
    return attempts_.back().carry = skills_.carry(plan, place, slot);
  }
  SkillResult place(const GraspPlan& plan, const Place& place,
                    const Eigen::Vector2d& slot) override {
    return attempts_.back().place = skills_.place(plan, place, slot);
  }

 private:
  ManipulationSkills& skills_;
  const Referee& referee_;
  std::vector<GraspAttempt>& attempts_;
  int& pushes_;
};

TrialOutcome outcome_of(SkillResult result) noexcept {
  switch (result) {
    case SkillResult::kCollision:
    case SkillResult::kLoadedCollision:
      return TrialOutcome::kCollisionAbort;
    case SkillResult::kFailedGrasp:
      return TrialOutcome::kFailedGrasp;
    case SkillResult::kSlipped:
      return TrialOutcome::kSlipped;
    case SkillResult::kUnreachable:
      return TrialOutcome::kUnreachable;
    case SkillResult::kDone:
      break;
  }
  return TrialOutcome::kSuccess;
}

/// `setting` presets the pieces, which may then be changed one by one.
void visit_strategy(ConfigVisitor& visitor, std::string& setting, ManipulationStrategy& strategy) {
  visitor.choice("setting", setting, {"paper", "best"});
  const std::vector<std::string> keys = visitor.keys();
  if (std::find(keys.begin(), keys.end(), "setting") != keys.end()) {
    strategy = setting == "best" ? ManipulationStrategy::best() : ManipulationStrategy{};
  }
  visitor.group("strategy", [&](ConfigVisitor& pieces) {
    pieces.boolean("hidden_sides", strategy.hidden_sides);
    pieces.boolean("uncertainty", strategy.uncertainty);
    pieces.boolean("verification", strategy.verification);
    pieces.boolean("regrasp", strategy.regrasp);
    pieces.boolean("second_look", strategy.second_look);
    pieces.boolean("steep_grasps", strategy.steep_grasps);
    pieces.boolean("clear_away", strategy.clear_away);
    pieces.boolean("search", strategy.search);
  });
}

/// Each kind of object once.
std::vector<ObjectModel> known_objects(const std::vector<ObjectModel>& in_scene) {
  std::vector<ObjectModel> known;
  std::set<std::string> names;
  for (const ObjectModel& object : in_scene) {
    if (names.insert(object.name).second) known.push_back(object);
  }
  return known;
}

}  // namespace

AttemptEnd end_of(const GraspAttempt& attempt) noexcept {
  if (attempt.grasp != SkillResult::kDone) {
    // Before the jaws have closed it was the approach.
    const bool before =
        attempt.grasp == SkillResult::kCollision || attempt.grasp == SkillResult::kUnreachable;
    return {outcome_of(attempt.grasp), before ? TrialStage::kApproach : TrialStage::kGrasp};
  }
  if (attempt.carry != SkillResult::kDone) return {outcome_of(attempt.carry), TrialStage::kCarry};
  if (attempt.place != SkillResult::kDone) return {outcome_of(attempt.place), TrialStage::kPlace};
  return {};
}

void VisionLoopParameters::visit(ConfigVisitor& visitor) {
  visitor.choice("perception", perception, {"camera", "truth"});
  visit_strategy(visitor, setting, strategy);
  visitor.choice("recognizer", recognizer, {"paper", "default"});
  visitor.boolean("camera_noise", camera_noise);
  visitor.number("stiffness_translation", stiffness_translation, {.min = 1.0, .max = 5000.0});
  visitor.number("stiffness_rotation", stiffness_rotation, {.min = 0.1, .max = 300.0});
  visitor.boolean("reaction", reaction);
  visitor.number("collision_force", collision_force, {.min = 1.0, .max = 500.0});
  visitor.number("approach_speed", approach_speed, {.min = 0.01, .max = 1.0});
  visitor.number("closing_speed", closing_speed, {.min = 0.005, .max = 0.42});
  visitor.number("grip_force", grip_force, {.min = 1.0, .max = 80.0});
  visitor.choice("physics", physics, {"drawn", "centre"});
  offsets.visit(visitor);
  visitor.number("time_budget_s", time_budget, {.min = 1.0, .max = 36000.0});
  visitor.group("plant", [&](ConfigVisitor& group) { plant.visit(group); });
}

SkillOptions VisionLoopParameters::skill_options() const {
  SkillOptions options;
  options.stiffness.head<3>().setConstant(stiffness_translation);
  options.stiffness.tail<3>().setConstant(stiffness_rotation);
  options.reaction = reaction;
  options.collision_force = collision_force;
  options.approach_speed = approach_speed;
  options.grip = {0.0, closing_speed, grip_force};
  options.strategy = strategy;
  return options;
}

RecognizerOptions VisionLoopParameters::recognizer_options() const {
  RecognizerOptions options;
  options.setting = recognizer == "paper" ? RecognizerSetting::kPaper : RecognizerSetting::kDefault;
  return options;
}

std::string VisionLoopParameters::cell_key() const {
  return fmt::format("{} {} {}", recognizer, strategy.uncertainty, strategy.steep_grasps);
}

VisionCell::VisionCell(const std::filesystem::path& scene_file,
                       const VisionLoopParameters& parameters) {
  const Scene scene = load_scene(scene_file);
  world = make_world_template(scene);
  std::vector<ObjectModel> objects = known_objects(world->parts.objects);
  recognizer = make_recognizer(objects, parameters.recognizer_options());
  knowledge = std::make_unique<RobotKnowledge>(cell_layout(scene), std::move(objects),
                                               GraspSelectionOptions::of(parameters.strategy));
  camera = std::make_unique<DepthCamera>(world);
}

void mark_oracle(const VisionLoopParameters& parameters, TrialRecord& record) {
  if (parameters.perception == "truth") record.measures["oracle_perception"] = 1.0;
}

void run_vision_loop(const VisionCell& cell, World& world, const VisionLoopParameters& parameters,
                     const AutomatonOptions& automaton_options, const TrialContext& context,
                     VisionLoopResult& result) {
  const Referee referee(world);
  TrialRecorder recorder(context, world);
  SimulatedRobotOptions options;
  options.camera_noise.enabled = parameters.camera_noise;
  options.time_budget = parameters.time_budget;
  options.seed = context.seeds.shared("sensors");
  options.on_step = recorder.callback();
  const ArmPlant plant(parameters.plant);
  plant.configure(options);
  parameters.offsets.configure(options, context);
  SimulatedRobot robot(world, cell.camera.get(), std::move(options));
  std::unique_ptr<Perception> perception;
  if (parameters.perception == "truth") {
    perception = std::make_unique<TruthPerception>(world);
  } else {
    perception = std::make_unique<RecognizerPerception>(cell.recognizer,
                                                        context.seeds.shared("recognition"));
  }
  SkillOptions skill_settings = parameters.skill_options();
  plant.configure(skill_settings);
  RobotSkills skills = cell.knowledge->make_skills(robot, perception.get(), skill_settings);
  ObservedSkills observed(skills, referee, result);
  AutomatonOptions settings = automaton_options;
  settings.strategy = parameters.strategy;
  ManipulationAutomaton automaton(observed, cell.knowledge->selector(), cell.knowledge->layout(),
                                  cell.knowledge->objects(), std::move(settings));
  automaton.on_state([&](AutomatonState state) { context.enter(stage_of(state)); });
  automaton.on_event([&](const AutomatonEvent& event) {
    result.automaton.events.push_back(event);
    recorder.note(event);
  });
  const AutomatonResult halted = automaton.run();
  result.automaton.reason = halted.reason;
  result.automaton.placed = halted.placed;
  // What was let go last comes to rest before the referee looks.
  skills.manipulator().hold(1.0, {.on_collision = false});
}

}  // namespace binpick
