#include "control/robot_skills.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "control/line_reach.h"
#include "models/mesh_geometry.h"

namespace binpick {
namespace {

// Settling after a motion before forces are read, s.
constexpr double kSettleTime = 0.1;
// Over which the load's wrench is averaged, s.
constexpr double kWeighTime = 0.05;
// What the jaws can hold by far, kg.
constexpr double kHeaviestPayload = 3.0;
// Measured points that are more than noise and stray edges of the table.
constexpr std::ptrdiff_t kLeastSurface = 200;
// What is seen this near to the highest point is taken for one object, m.
constexpr double kObjectRadius = 0.09;
// The forearm's way passes this much higher than what was seen, m.
constexpr double kPileMargin = 0.02;
// Moves to the overview pose that a touch on the way may interrupt.
constexpr int kOverviewAttempts = 3;
// The arm is at the overview pose when no joint is farther from it, rad.
constexpr double kThere = 0.01;
// Above the height at which an object should touch the floor, contact is not yet expected, m.
constexpr double kSinkMargin = 0.05;
// Orientations about the vertical that are tried for putting an object down.
constexpr int kYaws = 16;
// Against the margin to the joint limits, per m: a centimetre outside outweighs any posture.
constexpr double kOverflowWeight = 100.0;
// Holding a placed object down before letting go, s.
constexpr double kReleaseTime = 0.2;

SkillResult to_result(MotionEnd end, bool loaded) {
  switch (end) {
    case MotionEnd::kCollision:
      return loaded ? SkillResult::kLoadedCollision : SkillResult::kCollision;
    case MotionEnd::kLost:
      return SkillResult::kSlipped;
    case MotionEnd::kArrived:
    case MotionEnd::kContact:
      break;
  }
  return SkillResult::kDone;
}

Eigen::Isometry3d raised(const Eigen::Isometry3d& T_world_tcp, double height) {
  return Eigen::Translation3d(0.0, 0.0, height) * T_world_tcp;
}

/// The smallest rotation that turns the object's axis nearest to the vertical into the vertical:
/// what was grasped leaning is put down flat. Equivalent axes of symmetric objects count.
Eigen::Matrix3d upright_rotation(const Eigen::Matrix3d& R_world_object, const ObjectModel& object) {
  Eigen::Vector3d nearest = Eigen::Vector3d::UnitZ();
  double nearest_z = -1.0;
  for (const Eigen::Isometry3d& T_model_equivalent : object.symmetries) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3d direction = R_world_object * T_model_equivalent.linear().col(axis);
      if (direction.z() < 0.0) direction = -direction;
      if (direction.z() > nearest_z) {
        nearest_z = direction.z();
        nearest = direction;
      }
    }
  }
  return Eigen::Quaterniond::FromTwoVectors(nearest, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

ArmControllerOptions controller_options(const SkillOptions& options) {
  ArmControllerOptions controller;
  controller.cartesian.p_tcp_compliance_centre.z() = options.compliance_centre_offset;
  controller.joints = options.joints;
  return controller;
}

/// How far the object's outline reaches beyond the place, m.
double overflow(const Eigen::Isometry3d& T_world_object, const ObjectModel& object,
                const Place& place) {
  double worst = 0.0;
  for (const Eigen::Vector3d& vertex : object.mesh.vertices) {
    const Eigen::Vector2d offset = (T_world_object * vertex).head<2>() - place.p_world;
    worst = std::max(worst, (offset.cwiseAbs() - 0.5 * place.size).maxCoeff());
  }
  return worst;
}

/// The object at `slot`, standing on the place's floor, turned by `yaw`.
Eigen::Isometry3d put_down(const Eigen::Matrix3d& R_world_object, double yaw,
                           const ObjectModel& object, const Place& place,
                           const Eigen::Vector2d& slot) {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  T_world_object.linear() =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * R_world_object;
  T_world_object.translation() << slot, 0.0;
  const double bottom = lowest_point(T_world_object, object.mesh);
  T_world_object.translation().z() = place.floor_height - bottom;
  return T_world_object;
}

}  // namespace

RobotSkills::RobotSkills(const Parts& parts, const SkillOptions& options)
    : parts_(parts),
      options_(options),
      manipulator_(parts.robot, parts.model, controller_options(options)) {
  manipulator_.enable_reaction(options_.reaction);
}

void RobotSkills::enter(ContactPhase phase, double collision_force) {
  ContactThresholds thresholds = ContactThresholds::for_phase(phase, parts_.model.limits());
  thresholds.collision_force = collision_force;
  manipulator_.enter(phase, thresholds);
}

// State 1.
void RobotSkills::go_to_overview() {
  manipulator_.controller().clear_payload();
  enter(ContactPhase::kFree, options_.collision_force);
  const JointVector away = manipulator_.state().joints.q - parts_.layout.overview;
  if (away.cwiseAbs().maxCoeff() > kThere) return_to_overview();
  // Nothing is touched here: what the torque sensors feel is their own.
  if (!calibrated_) calibrated_ = manipulator_.calibrate_sensors();
}

void RobotSkills::return_to_overview() {
  // Away from whatever was touched first: straight up, jaws open, not minding contacts.
  withdraw(parts_.layout.transfer_height);
  manipulator_.command_gripper(
      {parts_.gripper.stroke.high, options_.grip.speed, options_.grip.force});
  for (int attempt = 0; attempt < kOverviewAttempts; ++attempt) {
    if (travel(find_path(manipulator_.state().joints.q, parts_.layout.overview),
               options_.free_motion, {}) == SkillResult::kDone) {
      break;
    }
    withdraw(parts_.layout.transfer_height);
  }
  manipulator_.hold(kSettleTime);
}

void RobotSkills::withdraw(double height) {
  const Eigen::Isometry3d T_world_tcp =
      parts_.model.forward_kinematics(manipulator_.state().joints.q);
  const double rise = height - T_world_tcp.translation().z();
  if (rise <= 0.0) return;
  manipulator_.controller().set_stiffness(options_.stiffness);
  manipulator_.move_line(raised(T_world_tcp, rise),
                         CartesianMotionLimits::at_speed(options_.withdraw_speed),
                         {.on_collision = false});
}

// State 2.
std::vector<Detection> RobotSkills::recognize() {
  std::vector<Detection> detections = look();
  const auto doubtful = [&](const Detection& detection) {
    return detection.confidence < options_.doubtful_confidence;
  };
  if (options_.strategy.second_look &&
      std::any_of(detections.begin(), detections.end(), doubtful)) {
    detections = merge_looks(std::move(detections), look());
  }
  if (options_.strategy.hidden_sides) {
    for (const Detection& detection : detections) {
      const ObjectModel* object = find_object(detection.model);
      if (object != nullptr) clearance_->add_object(detection, *object);
    }
  }
  return detections;
}

std::vector<Detection> RobotSkills::look() {
  const RangeImage image = manipulator_.capture();
  clearance_.emplace(image, parts_.gripper, parts_.layout.table_height);
  if (options_.strategy.search) {
    low_planner_.emplace(parts_.planner.over_pile(pile_height() + kPileMargin));
  }
  return parts_.perception->recognize(image);
}

double RobotSkills::pile_height() const {
  double highest = parts_.layout.table_height;
  for (const Eigen::Vector3d& p_world : clearance_->points_within(parts_.layout.pick_region)) {
    highest = std::max(highest, p_world.z());
  }
  return highest - parts_.layout.table_height;
}

template <class Goal>
std::optional<TransferPlanner::Path> RobotSkills::find_path(const JointVector& from,
                                                            const Goal& to) const {
  auto path = parts_.planner.plan(from, to);
  if (!path && low_planner_) path = low_planner_->plan(from, to);
  return path;
}

const ObjectModel* RobotSkills::find_object(const std::string& name) const {
  const auto found = std::find_if(parts_.objects.begin(), parts_.objects.end(),
                                  [&](const ObjectModel& object) { return object.name == name; });
  return found == parts_.objects.end() ? nullptr : &*found;
}

int RobotSkills::obstruction(const GraspPlan& plan) {
  return clearance_ ? clearance_->obstructing_points(plan) : 0;
}

double RobotSkills::hidden_share(const GraspPlan& plan) {
  return clearance_ ? clearance_->hidden_share(plan) : 0.0;
}

bool RobotSkills::has_way(const GraspPlan& plan, const Place& place, const Eigen::Vector2d& slot) {
  const auto path = find_path(parts_.layout.overview, plan.T_world_pregrasp);
  if (!path) return false;
  const auto q_grasp = after_line(plan.T_world_pregrasp, plan.T_world_grasp, path->back());
  if (!q_grasp) return false;
  const auto q_lifted =
      after_line(plan.T_world_grasp, raised(plan.T_world_grasp, options_.lift_height), *q_grasp);
  return q_lifted && plan_delivery(plan, place, slot, *q_lifted);
}

std::optional<JointVector> RobotSkills::after_line(const Eigen::Isometry3d& T_world_start,
                                                   const Eigen::Isometry3d& T_world_goal,
                                                   const JointVector& q) const {
  if (line_failure(parts_.kinematics, T_world_start, T_world_goal, q)) return std::nullopt;
  IkOptions nearby;
  nearby.min_margin = 0.0;
  nearby.continuity = 2.0;
  const IkResult result = parts_.kinematics.solve(T_world_goal, q, nearby);
  if (!result) return std::nullopt;
  return result->q;
}

// State 4.
SkillResult RobotSkills::grasp(const GraspPlan& plan) {
  enter(ContactPhase::kFree, options_.collision_force);
  manipulator_.command_gripper({plan.grasp->pre_opening, options_.grip.speed, options_.grip.force});
  const SkillResult end = travel(find_path(manipulator_.state().joints.q, plan.T_world_pregrasp),
                                 options_.free_motion, {});
  if (end != SkillResult::kDone) return end;
  const SkillResult grasped = execute_grasp(plan);
  // Whatever comes next begins above the pile.
  if (grasped == SkillResult::kFailedGrasp) withdraw(parts_.layout.transfer_height);
  return grasped;
}

SkillResult RobotSkills::execute_grasp(const GraspPlan& plan) {
  manipulator_.move_gripper({plan.grasp->pre_opening, options_.grip.speed, options_.grip.force});
  manipulator_.controller().set_stiffness(options_.stiffness);
  manipulator_.reset_peak_force();

  const JointVector& q = manipulator_.state().joints.q;
  if (line_failure(parts_.kinematics, parts_.model.forward_kinematics(q), plan.T_world_grasp, q)) {
    return SkillResult::kUnreachable;
  }
  enter(ContactPhase::kApproach, options_.collision_force);
  const MotionEnd approach = manipulator_.move_line(
      plan.T_world_grasp, CartesianMotionLimits::at_speed(options_.approach_speed));
  if (approach == MotionEnd::kCollision) return SkillResult::kCollision;
  if (manipulator_.hold(kSettleTime) == MotionEnd::kCollision) return SkillResult::kCollision;

  enter(ContactPhase::kGrasp, options_.loaded_collision_force);
  const GripperState closed = manipulator_.move_gripper(options_.grip);
  if (closed.width < parts_.gripper.closed_width) return SkillResult::kFailedGrasp;

  const MotionEnd lift =
      manipulator_.move_line(raised(plan.T_world_grasp, options_.lift_height),
                             CartesianMotionLimits::at_speed(options_.lift_speed), watching_load());
  if (lift != MotionEnd::kArrived) return to_result(lift, true);
  if (manipulator_.hold(kSettleTime, watching_load()) == MotionEnd::kLost) {
    return SkillResult::kSlipped;
  }
  weigh();
  if (options_.strategy.verification && !holds_as_planned(plan)) {
    put_back(plan);
    return SkillResult::kFailedGrasp;
  }
  return SkillResult::kDone;
}

bool RobotSkills::holds_as_planned(const GraspPlan& plan) const {
  return std::abs(hold_.width - plan.grasp->expected_width) < options_.width_tolerance &&
         hold_.mass > options_.least_load * plan.object->physics.mass.low;
}

void RobotSkills::put_back(const GraspPlan& plan) {
  enter(ContactPhase::kPlace, options_.loaded_collision_force);
  MotionStops until_contact = watching_load();
  until_contact.on_contact = true;
  manipulator_.move_line(plan.T_world_grasp, CartesianMotionLimits::at_speed(options_.lower_speed),
                         until_contact);
  let_go();
}

MotionStops RobotSkills::watching_load() const {
  const double closed_width = parts_.gripper.closed_width;
  return {
      .lost = [closed_width](const GripperState& gripper) { return gripper.width < closed_width; }};
}

void RobotSkills::weigh() {
  BodyInertia payload = manipulator_.weigh(kWeighTime);
  payload.mass = std::min(payload.mass, kHeaviestPayload);
  manipulator_.controller().set_payload(payload);
  hold_ = {manipulator_.state().gripper.width, payload.mass};
}

// State 5.
SkillResult RobotSkills::carry(const GraspPlan& plan, const Place& place,
                               const Eigen::Vector2d& slot) {
  const auto delivery = plan_delivery(plan, place, slot, manipulator_.state().joints.q);
  if (!delivery) return SkillResult::kUnreachable;
  placement_ = delivery->placement;
  enter(ContactPhase::kGrasp, options_.loaded_collision_force);
  const JointTrajectory way(delivery->path, parts_.model.limits(), options_.loaded_motion);
  const SkillResult end = to_result(manipulator_.follow(way, watching_load()), true);
  if (end == SkillResult::kDone && options_.strategy.verification && !still_holds()) {
    return SkillResult::kSlipped;
  }
  return end;
}

bool RobotSkills::still_holds() {
  manipulator_.hold(kSettleTime, {.on_collision = false});
  // The weight is in the controller's model already: what is felt is what is missing.
  const double width = manipulator_.state().gripper.width;
  return std::abs(width - hold_.width) < options_.width_tolerance &&
         manipulator_.missing_weight(kWeighTime) < (1.0 - options_.least_load) * hold_.mass;
}

std::optional<RobotSkills::Delivery> RobotSkills::plan_delivery(const GraspPlan& plan,
                                                                const Place& place,
                                                                const Eigen::Vector2d& slot,
                                                                const JointVector& q) const {
  for (const Placement& placement : placements(plan, place, slot, q)) {
    if (auto path = find_path(q, placement.T_world_above)) {
      return Delivery{placement, std::move(*path)};
    }
  }
  return std::nullopt;
}

std::vector<RobotSkills::Placement> RobotSkills::placements(const GraspPlan& plan,
                                                            const Place& place,
                                                            const Eigen::Vector2d& slot,
                                                            const JointVector& q) const {
  const Eigen::Isometry3d T_object_tcp = plan.grasp->T_object_grasp;
  const Eigen::Matrix3d R_world_object =
      upright_rotation(plan.detection.T_scene_model.linear(), *plan.object) *
      plan.detection.T_scene_model.linear();
  const double above =
      std::max(place.rim_height, parts_.layout.table_height) + options_.lift_height;

  std::vector<Placement> reached;
  for (int i = 0; i < kYaws; ++i) {
    const double yaw = 2.0 * std::numbers::pi * i / kYaws;
    const Eigen::Isometry3d T_world_object =
        put_down(R_world_object, yaw, *plan.object, place, slot);
    const Eigen::Isometry3d T_world_release = T_world_object * T_object_tcp;
    const double clear = above - lowest_point(T_world_object, plan.object->mesh);
    const Eigen::Isometry3d T_world_above = raised(T_world_release, clear);
    const IkResult q_above = parts_.kinematics.solve(T_world_above, q);
    const IkResult q_release = parts_.kinematics.solve(T_world_release, parts_.layout.overview);
    if (!q_above || !q_release) continue;
    const double cost = kOverflowWeight * overflow(T_world_object, *plan.object, place) -
                        std::min(q_above->margin, q_release->margin);
    reached.push_back({T_world_above, T_world_release, cost});
  }
  std::stable_sort(reached.begin(), reached.end(),
                   [](const Placement& a, const Placement& b) { return a.cost < b.cost; });
  return reached;
}

// State 6.
SkillResult RobotSkills::place(const GraspPlan&, const Place&, const Eigen::Vector2d&) {
  manipulator_.controller().set_stiffness(options_.stiffness);
  enter(ContactPhase::kPlace, options_.loaded_collision_force);
  // Contact is the expected end here; without one the object is let go where the floor should be.
  MotionStops until_contact = watching_load();
  until_contact.on_contact = true;
  MotionEnd lowering =
      manipulator_.move_line(raised(placement_->T_world_release, kSinkMargin),
                             CartesianMotionLimits::at_speed(options_.sink_speed), until_contact);
  if (lowering == MotionEnd::kArrived) {
    lowering = manipulator_.move_line(
        raised(placement_->T_world_release, -options_.place_clearance),
        CartesianMotionLimits::at_speed(options_.lower_speed), until_contact);
  }
  let_go();
  withdraw(parts_.layout.transfer_height);
  return lowering == MotionEnd::kLost ? SkillResult::kSlipped : SkillResult::kDone;
}

void RobotSkills::let_go() {
  GripperCommand release = options_.grip;
  release.width = std::min(manipulator_.state().gripper.width + options_.release_margin,
                           parts_.gripper.stroke.high);
  manipulator_.move_gripper(release);
  manipulator_.controller().clear_payload();
  manipulator_.hold(kReleaseTime, {.on_collision = false});
}

std::vector<Eigen::Vector3d> RobotSkills::unrecognized_surface() {
  const std::vector<Eigen::Vector3d> above_table =
      clearance_->points_within(parts_.layout.pick_region);
  if (std::ssize(above_table) < kLeastSurface) return {};
  const auto highest = std::max_element(
      above_table.begin(), above_table.end(),
      [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.z() < b.z(); });
  std::vector<Eigen::Vector3d> near;
  for (const Eigen::Vector3d& p_world : above_table) {
    if ((p_world - *highest).head<2>().norm() < kObjectRadius) near.push_back(p_world);
  }
  return near;
}

SkillResult RobotSkills::push(const std::vector<Eigen::Vector3d>& surface) {
  std::optional<TransferPlanner::Path> path;
  const auto feasible = [&](const Push& push) {
    path = find_path(manipulator_.state().joints.q, push.T_world_before);
    if (!path) return false;
    const auto q_start = after_line(push.T_world_before, push.T_world_start, path->back());
    return q_start && after_line(push.T_world_start, push.T_world_end, *q_start);
  };
  const std::optional<Push> push = plan_push(surface, parts_.layout, parts_.gripper, feasible);
  if (!push) return SkillResult::kUnreachable;

  enter(ContactPhase::kFree, options_.collision_force);
  manipulator_.command_gripper(
      {parts_.gripper.stroke.low, options_.grip.speed, options_.grip.force});
  const SkillResult end = travel(path, options_.free_motion, {});
  if (end != SkillResult::kDone) return end;
  manipulator_.controller().set_stiffness(options_.stiffness);
  enter(ContactPhase::kApproach, options_.collision_force);
  MotionEnd pushed = manipulator_.move_line(
      push->T_world_start, CartesianMotionLimits::at_speed(options_.approach_speed));
  if (pushed == MotionEnd::kArrived) {
    enter(ContactPhase::kGrasp, options_.loaded_collision_force);
    pushed = manipulator_.move_line(push->T_world_end,
                                    CartesianMotionLimits::at_speed(options_.approach_speed));
  }
  withdraw(parts_.layout.transfer_height);
  return to_result(pushed, false);
}

SkillResult RobotSkills::travel(const std::optional<TransferPlanner::Path>& path,
                                const JointMotionOptions& motion, const MotionStops& stops) {
  if (!path) return SkillResult::kUnreachable;
  return to_result(
      manipulator_.follow(JointTrajectory(*path, parts_.model.limits(), motion), stops), false);
}

}  // namespace binpick
