#include "experiments/blind_grasp_trial.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

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

void BlindGraspTrial::visit(ConfigVisitor& visitor) {
  Parameters& p = parameters_;
  visitor.text("scene", p.scene, Presence::kRequired);
  visitor.text("grasp", p.grasp, Presence::kRequired);
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
  visitor.boolean("reaction", p.reaction);
  visitor.number("collision_force", p.collision_force, {.min = 1.0, .max = 500.0});
  visitor.number("approach_speed", p.approach_speed, {.min = 0.01, .max = 1.0});
  visitor.interval("closing_speed", p.closing_speed, {.min = 0.005, .max = 0.42});
  visitor.number("grip_force", p.grip_force, {.min = 1.0, .max = 80.0});
  visitor.number("lift_height", p.lift_height, {.min = 0.12, .max = 0.3});
  visitor.number("hold_time", p.hold_time, {.min = 0.0, .max = 60.0});
  visitor.choice("physics", p.physics, {"drawn", "centre"});
}

std::vector<std::filesystem::path> BlindGraspTrial::input_files(
    const std::filesystem::path& config_directory) const {
  return trial_input_files(config_directory / parameters_.scene);
}

void BlindGraspTrial::prepare(const std::filesystem::path& config_directory) {
  const std::string file = (config_directory / parameters_.scene).string();
  if (loaded_scene_ != file) {
    const Scene scene = load_scene(file);
    if (scene.object_names().size() != 1) {
      throw InputError(
          fmt::format("{}: a blind grasp wants a scene with one standing object", file));
    }
    world_ = make_world_template(scene);
    knowledge_ = std::make_unique<RobotKnowledge>(cell_layout(scene), world_->parts.objects);
    loaded_scene_ = file;
  }
  const World world(world_, centre_physics(world_->parts.objects));
  (void)nominal_plan(world);
}

GraspPlan BlindGraspTrial::nominal_plan(const World& world) const {
  const Detection believed{world.object_model(0).name, world.object_pose(0)};
  for (GraspPlan& plan : knowledge_->selector().feasible_grasps(believed)) {
    if (plan.grasp->name == parameters_.grasp) return plan;
  }
  throw InputError(fmt::format("{}: the object has no feasible grasp named '{}'", loaded_scene_,
                               parameters_.grasp));
}

SkillOptions BlindGraspTrial::skill_options(const TrialContext& context) const {
  const Parameters& p = parameters_;
  SkillOptions options;
  options.stiffness << p.stiffness_x, p.stiffness_y, p.stiffness_z, p.stiffness_rx, p.stiffness_ry,
      p.stiffness_rz;
  options.reaction = p.reaction;
  options.collision_force = p.collision_force;
  options.approach_speed = p.approach_speed;
  options.lift_height = p.lift_height;
  Random draw(context.seeds.shared("closing speed"));
  options.grip = {0.0, draw.uniform(p.closing_speed.low, p.closing_speed.high), p.grip_force};
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
  World world(world_, physics_of_trial(world_->parts.objects, parameters_.physics, context));
  const GraspPlan plan = nominal_plan(world);
  world.set_arm_position(plan.q_pregrasp, plan.grasp->pre_opening);

  Random draw(context.seeds.shared("pose error"));
  const double direction = draw.uniform(0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector3d error =
      parameters_.pose_error * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
  world.set_object_pose(0, Eigen::Translation3d(error) * world.object_pose(0));
  record.measures["error_direction_rad"] = direction;

  TrialRecorder recorder(context, world);
  SimulatedRobot robot(world, nullptr,
                       {.camera_noise = {},
                        .sensor_noise = {},
                        .time_budget = kTimeBudget,
                        .seed = context.seeds.shared("sensors"),
                        .on_step = recorder.callback()});
  RobotSkills skills = knowledge_->make_skills(robot, nullptr, skill_options(context));

  context.enter(TrialStage::kApproach);
  const SkillResult grasp = skills.execute_grasp(plan);
  record.measures["peak_force_n"] = skills.manipulator().peak_force();
  if (grasp == SkillResult::kCollision) {
    return fail(record, TrialOutcome::kCollisionAbort, TrialStage::kApproach);
  }
  if (grasp == SkillResult::kFailedGrasp) {
    return fail(record, TrialOutcome::kFailedGrasp, TrialStage::kGrasp);
  }
  context.enter(TrialStage::kJudge);
  skills.manipulator().hold(parameters_.hold_time, {.on_collision = false});
  record.measures["jaw_width_m"] = robot.state().gripper.width;
  if (!Referee(world).held_aloft(0, kHeldHeight)) {
    fail(record, TrialOutcome::kSlipped, TrialStage::kJudge);
  }
}

}  // namespace binpick
