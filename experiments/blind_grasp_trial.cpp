#include "experiments/blind_grasp_trial.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "experiments/referee.h"
#include "experiments/trial_recorder.h"
#include "experiments/trial_setup.h"
#include "models/errors.h"
#include "sim/simulated_robot.h"

namespace binpick {
namespace {

// The bottle must end clear of the table by this much, m; it is lifted by more.
constexpr double kHeldHeight = 0.10;
// Simulated time that no attempt needs, s.
constexpr double kTimeBudget = 60.0;

}  // namespace

void BlindGraspTrial::visit(ConfigVisitor& visitor) { parameters_.visit(visitor); }

void BlindGraspTrial::FixedPhysics::visit(ConfigVisitor& visitor) {
  visitor.number("mass", mass, {.min = 0.0, .max = 3.0});
  visitor.number("table_friction", table_friction, {.min = 0.0, .max = 2.0});
  visitor.number("pad_friction", pad_friction, {.min = 0.0, .max = 2.0});
  visitor.number("closing_speed", closing_speed, {.min = 0.0, .max = 0.42});
}

void BlindGraspTrial::Parameters::visit(ConfigVisitor& visitor) {
  Parameters& p = *this;
  visitor.text("scene", p.scene, Presence::kRequired);
  visitor.text("grasp", p.grasp, Presence::kRequired);
  visitor.number("grasp_turn_deg", p.grasp_turn, {.min = -180.0, .max = 180.0, .unit = kDegree});
  visitor.number("grasp_tilt_deg", p.grasp_tilt, {.min = -29.0, .max = 29.0, .unit = kDegree});
  visitor.number("grasp_raise", p.grasp_raise, {.min = -0.1, .max = 0.1});
  visitor.number("pre_opening", p.pre_opening, {.min = 0.0, .max = 0.16});
  visitor.number("pad_width", p.pad_width, {.min = 0.0, .max = 0.05});
  visitor.number("pose_error", p.pose_error, {.min = 0.0, .max = 0.2});
  visitor.group("stiffness", [&](ConfigVisitor& group) {
    const NumberSpec translation{.min = 0.0, .max = 5000.0};
    const NumberSpec rotation{.min = 0.0, .max = 300.0};
    group.number("translation_x", p.stiffness_x, translation);
    group.number("translation_y", p.stiffness_y, translation);
    group.number("translation_z", p.stiffness_z, translation);
    group.number("rotation_x", p.stiffness_rx, rotation);
    group.number("rotation_y", p.stiffness_ry, rotation);
    group.number("rotation_z", p.stiffness_rz, rotation);
  });
  visitor.number("compliance_centre_offset", p.compliance_centre_offset, {.min = -0.3, .max = 0.1});
  visitor.boolean("reaction", p.reaction);
  visitor.number("collision_force", p.collision_force, {.min = 1.0, .max = 500.0});
  visitor.number("approach_speed", p.approach_speed, {.min = 0.01, .max = 1.0});
  visitor.interval("closing_speed", p.closing_speed, {.min = 0.005, .max = 0.42});
  visitor.number("grip_force", p.grip_force, {.min = 1.0, .max = 80.0});
  visitor.number("lift_height", p.lift_height, {.min = 0.12, .max = 0.3});
  visitor.number("hold_time", p.hold_time, {.min = 0.0, .max = 60.0});
  p.offsets.visit(visitor);
  visitor.choice("physics", p.physics, {"drawn", "centre"});
  visitor.group("fixed", [&](ConfigVisitor& inner) { p.fixed.visit(inner); });
  visitor.group("plant", [&](ConfigVisitor& inner) { p.plant.visit(inner); });
}

std::vector<std::filesystem::path> BlindGraspTrial::input_files(
    const std::filesystem::path& config_directory) const {
  return trial_input_files(config_directory / parameters_.scene);
}

void BlindGraspTrial::prepare(const std::filesystem::path& config_directory) {
  const std::string file = (config_directory / parameters_.scene).string();
  const Parameters& p = parameters_;
  const std::string cell = fmt::format("{}, pads {}", file, p.pad_width);
  const std::string grasp = fmt::format("{}, {} {} {} {} {}", cell, p.grasp, p.grasp_turn,
                                        p.grasp_tilt, p.grasp_raise, p.pre_opening);
  if (std::exchange(loaded_cell_, cell) != cell) load_world(file);
  if (std::exchange(loaded_grasp_, grasp) != grasp) {
    knowledge_ =
        std::make_unique<RobotKnowledge>(cell_layout(world_->parts.scene), objects_to_grasp());
  }
  const World world(world_, centre_physics(world_->parts.objects));
  (void)nominal_plan(world);
}

void BlindGraspTrial::load_world(const std::string& scene_file) {
  const Scene scene = load_scene(scene_file);
  if (scene.object_names().size() != 1) {
    throw InputError(fmt::format("{}: a blind grasp wants a scene with one object", scene_file));
  }
  world_ = make_world_template(scene);
  if (parameters_.pad_width > 0.0) {
    WorldParts parts = world_->parts;
    parts.gripper.pad_width = parameters_.pad_width;
    world_ = make_world_template(std::move(parts));
  }
}

std::vector<ObjectModel> BlindGraspTrial::objects_to_grasp() const {
  const Parameters& p = parameters_;
  std::vector<ObjectModel> objects = world_->parts.objects;
  for (Grasp& grasp : objects.front().grasps) {
    if (grasp.name != p.grasp) continue;
    grasp.T_object_grasp = grasp.T_object_grasp * Eigen::Translation3d(0.0, 0.0, -p.grasp_raise) *
                           Eigen::AngleAxisd(p.grasp_turn, Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(p.grasp_tilt, Eigen::Vector3d::UnitY());
    if (p.pre_opening > 0.0) grasp.pre_opening = p.pre_opening;
  }
  return objects;
}

PhysicsDraw BlindGraspTrial::physics(const TrialContext& context) const {
  PhysicsDraw draw = physics_of_trial(world_->parts.objects, parameters_.physics, context);
  const FixedPhysics& fixed = parameters_.fixed;
  ObjectDraw& object = draw.objects.front();
  if (fixed.mass > 0.0) object.mass = fixed.mass;
  if (fixed.table_friction > 0.0) object.table_friction = fixed.table_friction;
  if (fixed.pad_friction > 0.0) object.pad_friction = fixed.pad_friction;
  return draw;
}

GraspPlan BlindGraspTrial::nominal_plan(const World& world) const {
  const Detection believed{world.object_model(0).name, world.object_pose(0)};
  for (GraspPlan& plan : knowledge_->selector().feasible_grasps(believed)) {
    if (plan.grasp->name == parameters_.grasp) return plan;
  }
  throw InputError(fmt::format("{}: the object has no feasible grasp named '{}'", parameters_.scene,
                               parameters_.grasp));
}

SkillOptions BlindGraspTrial::skill_options(const TrialContext& context) const {
  const Parameters& p = parameters_;
  SkillOptions options;
  options.stiffness << p.stiffness_x, p.stiffness_y, p.stiffness_z, p.stiffness_rx, p.stiffness_ry,
      p.stiffness_rz;
  options.compliance_centre_offset = p.compliance_centre_offset;
  options.reaction = p.reaction;
  options.collision_force = p.collision_force;
  options.approach_speed = p.approach_speed;
  options.lift_height = p.lift_height;
  Random draw(context.seeds.shared("closing speed"));
  const double drawn_speed = draw.uniform(p.closing_speed.low, p.closing_speed.high);
  const double speed = p.fixed.closing_speed > 0.0 ? p.fixed.closing_speed : drawn_speed;
  options.grip = {0.0, speed, p.grip_force};
  return options;
}

TrialRecord BlindGraspTrial::run(const TrialContext& context) {
  TrialRecord record;
  run_in_simulation(context, record,
                    [&](const TrialContext& observed) { attempt(observed, record); });
  return record;
}

void BlindGraspTrial::attempt(const TrialContext& context, TrialRecord& record) const {
  context.enter(TrialStage::kSetup);
  const ArmPlant plant(parameters_.plant);
  SimulatedRobotOptions options;
  plant.configure(options);
  parameters_.offsets.configure(options, context);
  options.time_budget = kTimeBudget;
  options.seed = context.seeds.shared("sensors");
  World world(world_, physics(context), plant.drives());
  const GraspPlan plan = nominal_plan(world);
  world.set_arm_position(plan.q_pregrasp, plan.grasp->pre_opening + options.jaw_offset);

  Random draw(context.seeds.shared("pose error"));
  const double direction = draw.uniform(0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector3d error =
      parameters_.pose_error * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
  world.set_object_pose(0, Eigen::Translation3d(error) * world.object_pose(0));
  record.measures["error_direction_rad"] = direction;

  TrialRecorder recorder(context, world);
  options.on_step = recorder.callback();
  SimulatedRobot robot(world, nullptr, std::move(options));
  SkillOptions skill_settings = skill_options(context);
  plant.configure(skill_settings);
  RobotSkills skills = knowledge_->make_skills(robot, nullptr, skill_settings);

  context.enter(TrialStage::kApproach);
  const SkillResult grasp = skills.execute_grasp(plan);
  record.measures["peak_force_n"] = skills.manipulator().peak_force();
  if (grasp == SkillResult::kCollision) {
    return fail(record, TrialOutcome::kCollisionAbort, TrialStage::kApproach);
  }
  if (grasp == SkillResult::kFailedGrasp) {
    return fail(record, TrialOutcome::kFailedGrasp, TrialStage::kGrasp);
  }
  if (grasp == SkillResult::kSlipped) {
    return fail(record, TrialOutcome::kSlipped, TrialStage::kGrasp);
  }
  if (grasp == SkillResult::kLoadedCollision) {
    return fail(record, TrialOutcome::kCollisionAbort, TrialStage::kGrasp);
  }
  context.enter(TrialStage::kJudge);
  skills.manipulator().hold(parameters_.hold_time, {.on_collision = false});
  record.measures["jaw_width_m"] = robot.state().gripper.width;
  if (!held_aloft(world, 0, kHeldHeight)) {
    fail(record, TrialOutcome::kSlipped, TrialStage::kJudge);
  }
}

}  // namespace binpick
