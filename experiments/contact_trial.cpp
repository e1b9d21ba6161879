#include "experiments/contact_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/arm_controller.h"
#include "control/cartesian_trajectory.h"
#include "experiments/trial_recorder.h"
#include "experiments/trial_setup.h"
#include "models/errors.h"

namespace binpick {
namespace {

// 0.8 m/s are reached and left within 3.2 cm: less than approach and overshoot.
constexpr double kAcceleration = 12.0;  // m/s^2
constexpr double kJerk = 1200.0;        // m/s^3
// Above the stiffest spring at full overshoot, so that the clip decides nothing.
constexpr double kMaxSpringForce = 400.0;  // N
// Published speed limits of joints 5 to 7 lie between 112.5 and 204 deg/s. Motions are planned with
// the lowest; 0.8 m/s straight down need 132 deg/s of joint 6, so the paper's arm had more.
constexpr double kWristSpeed = 180.0 * kDegree;  // rad/s
constexpr std::size_t kFirstWristJoint = 4;
constexpr double kTouch = 1e-6;         // N
constexpr double kSustainedTime = 0.2;  // s, at the end

CartesianTrajectory straight_down(const Eigen::Isometry3d& T_world_start, double distance,
                                  double speed) {
  CartesianMotionLimits limits;
  limits.linear = {speed, kAcceleration, kJerk};
  return {T_world_start, Eigen::Translation3d(0.0, 0.0, -distance) * T_world_start, limits};
}

/// The mass that a vertical blow at the tool centre meets, links and tool only, kg.
double effective_mass(const ArmDynamics& dynamics) {
  const JointVector upward = dynamics.J.row(2).transpose();
  return 1.0 / upward.dot(dynamics.M.llt().solve(upward));
}

void summarize(const ContactSeries& series, double stiffness, double mass, TrialRecord& record) {
  auto& measures = record.measures;
  const auto touch = std::find_if(series.begin(), series.end(), [](const ContactSample& sample) {
    return sample.true_force > kTouch;
  });
  if (touch == series.end()) {
    record.note = "the surface was never touched";
    return;
  }
  double peak = 0.0;
  double estimated_peak = 0.0;
  for (const ContactSample& sample : series) {
    peak = std::max(peak, sample.true_force);
    estimated_peak = std::max(estimated_peak, sample.estimated_force);
  }
  const auto last = static_cast<std::size_t>(kSustainedTime / kControlPeriod);
  double sustained = 0.0;
  for (auto sample = series.end() - long(last); sample != series.end(); ++sample) {
    sustained += sample->true_force / static_cast<double>(last);
  }
  const double speed = -(touch == series.begin() ? touch : touch - 1)->velocity;
  measures["contact_speed_m_s"] = speed;
  measures["effective_mass_kg"] = mass;
  measures["predicted_first_peak_n"] = speed * std::sqrt(mass * stiffness);
  measures["first_peak_n"] = first_force_peak(series);
  measures["peak_n"] = peak;
  measures["estimated_peak_n"] = estimated_peak;
  measures["sustained_n"] = sustained;
  measures["final_height_m"] = series.back().height;
  const auto detected = std::find_if(touch, series.end(),
                                     [](const ContactSample& sample) { return sample.collision; });
  if (detected != series.end()) measures["detection_latency_s"] = detected->time - touch->time;
}

}  // namespace

void ContactTrial::visit(ConfigVisitor& visitor) {
  Parameters& p = parameters_;
  visitor.text("scene", p.scene, Presence::kRequired);
  visitor.number("height", p.height, {.min = 0.05, .max = 0.4});
  visitor.number("approach", p.approach, {.min = 0.01, .max = 0.3});
  visitor.number("overshoot", p.overshoot, {.min = 0.0, .max = 0.1});
  visitor.number("speed", p.speed, {.min = 0.01, .max = 1.0});
  visitor.number("hold_time", p.hold_time, {.min = 0.5, .max = 10.0});
  visitor.number("stiffness_z", p.stiffness_z, {.min = 1.0, .max = 5000.0});
  visitor.number("stiffness_xy", p.stiffness_xy, {.min = 1.0, .max = 5000.0});
  visitor.number("stiffness_rotation", p.stiffness_rotation, {.min = 0.1, .max = 300.0});
  visitor.boolean("reaction", p.reaction);
  visitor.number("collision_force", p.collision_force, {.min = 1.0, .max = 500.0});
  visitor.number("contact_stiffness", p.contact_stiffness, {.min = 100.0, .max = 200000.0});
  visitor.number("held_mass", p.held_mass, {.min = 0.0, .max = 3.0});
  visitor.number("held_length", p.held_length, {.min = 0.015, .max = 0.1});
  visitor.group("plant", [&](ConfigVisitor& group) { p.plant.visit(group); });
}

std::vector<std::filesystem::path> ContactTrial::input_files(
    const std::filesystem::path& config_directory) const {
  return trial_input_files(config_directory / parameters_.scene);
}

void ContactTrial::prepare(const std::filesystem::path& config_directory) {
  const std::string file = (config_directory / parameters_.scene).string();
  const std::string wanted = fmt::format("{} {}", file, parameters_.held_mass);
  if (loaded_ == wanted) return;
  WorldParts parts = make_world_template(load_scene(file))->parts;
  knowledge_ = std::make_unique<RobotKnowledge>(cell_layout(parts.scene), parts.objects);
  for (std::size_t i = kFirstWristJoint; i < kArmJoints; ++i) {
    parts.arm.joints[i].velocity = kWristSpeed;
  }
  arm_ = std::make_unique<ArmModel>(parts.arm, parts.gripper, knowledge_->layout().T_world_base);
  if (parameters_.held_mass > 0.0) {
    // Held fast: as one body with the gripper.
    parts.gripper.body =
        combine(parts.gripper.body, transformed(parts.gripper.T_flange_tcp, held_block()));
  }
  world_ = make_world_template(std::move(parts));
  loaded_ = wanted;
}

BodyInertia ContactTrial::held_block() const {
  const double side = 0.06;  // m, in plan
  const GripperDescription& gripper = knowledge_->gripper();
  const double palm = gripper.tip_beyond_tcp - gripper.finger_length;
  const double length = parameters_.held_length - palm;
  const double mass = parameters_.held_mass;
  BodyInertia block;
  block.mass = mass;
  block.com.z() = 0.5 * (parameters_.held_length + palm);
  const double across = mass / 12.0 * (side * side + length * length);
  block.inertia.diagonal() << across, across, mass / 6.0 * side * side;
  return block;
}

CompliantSurface ContactTrial::surface() const {
  CompliantSurface surface;
  surface.height = parameters_.height;
  surface.stiffness = parameters_.contact_stiffness;
  surface.p_tcp.z() =
      parameters_.held_mass > 0.0 ? parameters_.held_length : knowledge_->gripper().tip_beyond_tcp;
  return surface;
}

ArmControllerOptions ContactTrial::controller_options(const ArmPlant& plant) const {
  ArmControllerOptions options;
  options.cartesian.stiffness << parameters_.stiffness_xy, parameters_.stiffness_xy,
      parameters_.stiffness_z, Eigen::Vector3d::Constant(parameters_.stiffness_rotation);
  options.cartesian.max_spring_force = kMaxSpringForce;
  plant.configure(options);
  return options;
}

TrialRecord ContactTrial::run(const TrialContext& context) {
  TrialRecord record;
  ContactSeries series;
  run_in_simulation(context, record,
                    [&](const TrialContext& observed) { press(observed, series, record); });
  if (context.trace) write_contact_series(*context.trace / "contact.csv", series);
  return record;
}

ContactSeries ContactTrial::time_series(const TrialContext& context) const {
  TrialRecord record;
  ContactSeries series;
  run_in_simulation(context, record,
                    [&](const TrialContext& observed) { press(observed, series, record); });
  return series;
}

void ContactTrial::press(const TrialContext& context, ContactSeries& series,
                         TrialRecord& record) const {
  context.enter(TrialStage::kSetup);
  const Parameters& p = parameters_;
  const ArmPlant plant(p.plant);
  World world(world_, centre_physics(world_->parts.objects), plant.drives());
  for (int i = 0; i < world.object_count(); ++i) world.park_object(i);
  const CompliantSurface touched = surface();
  world.set_surface(touched);

  Eigen::Isometry3d T_world_start = Eigen::Isometry3d::Identity();
  T_world_start.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_world_start.translation() << world_->parts.scene.pick_region_centre,
      p.height + touched.p_tcp.z() + p.approach;
  const auto q_start = knowledge_->reach(T_world_start);
  if (!q_start) throw InputError(loaded_ + ": the arm cannot reach the start of the motion");
  world.set_arm_position(*q_start, p.held_mass > 0.0 ? 0.06 : 0.0);

  TrialRecorder recorder(context, world);
  SimulatedRobotOptions options;
  options.seed = context.seeds.shared("sensors");
  options.on_step = recorder.callback();
  plant.configure(options);
  SimulatedRobot robot(world, nullptr, options);

  ArmController controller(*arm_, controller_options(plant));
  if (p.held_mass > 0.0) controller.set_payload(held_block());
  ContactThresholds thresholds =
      ContactThresholds::for_phase(ContactPhase::kApproach, arm_->limits());
  thresholds.collision_force = p.collision_force;
  controller.set_thresholds(thresholds);

  context.enter(TrialStage::kApproach);
  const CartesianTrajectory line = straight_down(T_world_start, p.approach + p.overshoot, p.speed);
  const auto ticks = static_cast<int>((line.duration() + p.hold_time) / kControlPeriod);
  CartesianTarget target = line.sample(0.0);
  double mass = 0.0;
  bool stopped = false;
  RobotCommand command;
  command.gripper.width = robot.state().gripper.width;
  for (int i = 1; i <= ticks; ++i) {
    if (!stopped) {
      target = line.sample(i * kControlPeriod);
      controller.set_cartesian_target(target);
    }
    command.tau = controller.tick(robot.state().joints, kControlPeriod);
    const ArmStatus& status = controller.status();
    if (p.reaction && status.collision && !stopped) {
      stopped = true;
      controller.stop();
      target = {.T_world_tcp = status.T_world_tcp};
    }
    if (world.surface_force() <= kTouch) mass = effective_mass(status.dynamics);
    const double estimate = status.external_wrench.z();
    const double spring = -status.spring_wrench.z();
    const bool collision = status.collision;
    robot.exchange(command);
    const double contact_height = p.height + touched.p_tcp.z();
    const Eigen::Vector3d p_tcp = world.T_world_tcp().translation();
    const double velocity =
        series.empty() ? 0.0 : (p_tcp.z() - contact_height - series.back().height) / kControlPeriod;
    series.push_back({i * kControlPeriod, target.T_world_tcp.translation().z() - contact_height,
                      p_tcp.z() - contact_height, target.twist[2], velocity, spring,
                      world.surface_force(), estimate, collision});
  }
  context.enter(TrialStage::kJudge);
  summarize(series, touched.stiffness, mass, record);
}

}  // namespace binpick
