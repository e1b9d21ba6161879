#include "sim/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "sim/simulation_error.h"

namespace binpick {
namespace {

constexpr double kAway = 50.0;          // height of what is out of the cell, m
constexpr double kBrakeInertia = 1e6;   // kg m^2
constexpr double kGrippingForce = 1.0;  // N; what moves free jaws stays below most of the time

bool all_finite(const mjtNum* values, int count) {
  return std::all_of(values, values + count, [](mjtNum value) { return std::isfinite(value); });
}

}  // namespace

World::World(std::shared_ptr<const WorldTemplate> shared, const PhysicsDraw& physics,
             const std::optional<DriveDescription>& drives, int substeps)
    : shared_(std::move(shared)),
      model_(mj_copyModel(nullptr, shared_->model.get())),
      data_(mj_makeData(model_.get())),
      gripper_(shared_->parts.gripper),
      parked_(shared_->parts.objects.size(), true) {
  install_mujoco_handlers();
  if (drives) {
    if (substeps < 1 || (substeps > 1 && substeps % kTorqueLoopsPerControl != 0)) {
      throw std::invalid_argument(
          "elastic joints need one physics step or whole ones per torque loop");
    }
    drives_.emplace(*drives);
    substeps_ = substeps;
    model_->opt.timestep = kStep / substeps;
  }
  enter_physics(physics);
  close_brakes(arm_held_);
  mj_resetData(model_.get(), data_.get());
  set_arm_position(shared_->parts.scene.overview, shared_->parts.gripper.stroke.high);
  for (int i = 0; i < object_count(); ++i) park_object(i);
  place_objects();
  mj_forward(model_.get(), data_.get());
}

void World::enter_physics(const PhysicsDraw& physics) {
  const WorldIndex& index = shared_->index;
  if (physics.objects.size() != index.object_body.size()) {
    throw std::invalid_argument("a physics draw must have one entry per object");
  }
  for (std::size_t i = 0; i < physics.objects.size(); ++i) {
    const int body = index.object_body[i];
    const double scale = physics.objects[i].mass / model_->body_mass[body];
    model_->body_mass[body] *= scale;
    for (int axis = 0; axis < 3; ++axis) model_->body_inertia[3 * body + axis] *= scale;
  }
  for (int pair = 0; pair < model_->npair; ++pair) {
    if (const auto friction = pair_friction(pair, physics)) {
      model_->pair_friction[5 * pair] = *friction;
      model_->pair_friction[5 * pair + 1] = *friction;
    }
  }
  mj_setConst(model_.get(), data_.get());
}

// Empty for pairs of the bare robot, which keep their friction.
std::optional<double> World::pair_friction(int pair, const PhysicsDraw& physics) const {
  const WorldIndex& index = shared_->index;
  const std::array<int, 2> geoms{model_->pair_geom1[pair], model_->pair_geom2[pair]};
  std::array<int, 2> owners{};
  for (std::size_t i = 0; i < 2; ++i) owners[i] = index.geom_object[std::size_t(geoms[i])];
  const int object = std::max(owners[0], owners[1]);
  const int other = std::min(owners[0], owners[1]);
  if (object < 0) return std::nullopt;
  const ObjectDraw& draw = physics.objects[std::size_t(object)];
  if (other == WorldIndex::kCell) return draw.table_friction;
  if (other >= 0) {
    return 0.5 * (draw.object_friction + physics.objects[std::size_t(other)].object_friction);
  }
  for (const int pad : index.pad_geom) {
    if (pad == geoms[0] || pad == geoms[1]) return draw.pad_friction;
  }
  return std::nullopt;
}

void World::place_objects() {
  const Scene& scene = shared_->parts.scene;
  if (scene.arrangement != "standing") return;
  for (std::size_t i = 0; i < scene.standing.size(); ++i) {
    const StandingObject& object = scene.standing[i];
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = object.R_world_object();
    T.translation().head<2>() = object.position;
    set_object_pose(static_cast<int>(i), T);
    T.translation().z() = -object_lowest_point(static_cast<int>(i));
    set_object_pose(static_cast<int>(i), T);
  }
}

void World::step() {
  drive_gripper();
  for (int i = 0; i < substeps_; ++i) {
    if (!drives_ || arm_held_) {
      if (surface_) clear_applied_torques();
      step_physics();
      continue;
    }
    if (substeps_ == 1) {
      step_elastic_arm(kTorqueLoopsPerControl, true);
    } else {
      step_elastic_arm(1, i % (substeps_ / kTorqueLoopsPerControl) == 0);
    }
  }
}

void World::step_physics() {
  const double time_before = data_->time;
  if (surface_) press_surface();
  mj_step(model_.get(), data_.get());
  check_step(time_before);
  pin();
}

void World::clear_applied_torques() {
  for (const int dof : shared_->index.arm_dof) data_->qfrc_applied[dof] = 0.0;
}

void World::press_surface() {
  refresh_poses();
  mj_comPos(model_.get(), data_.get());
  const int site = shared_->index.tcp_site;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_world_tcp(
      data_->site_xmat + 9 * site);
  const Eigen::Vector3d p_world = R_world_tcp * surface_->p_tcp +
                                  Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * site);
  std::vector<mjtNum> jacobian(3 * static_cast<std::size_t>(model_->nv));
  mj_jac(model_.get(), data_.get(), jacobian.data(), nullptr, p_world.data(),
         model_->site_bodyid[site]);
  const mjtNum* upward = jacobian.data() + 2 * model_->nv;

  const double depth = surface_->height - p_world.z();
  const double sinking = -mju_dot(upward, data_->qvel, model_->nv);
  surface_force_ =
      depth > 0.0
          ? std::max(0.0, surface_->stiffness * depth * (1.0 + surface_->dissipation * sinking))
          : 0.0;
  for (const int dof : shared_->index.arm_dof) {
    data_->qfrc_applied[dof] += upward[dof] * surface_force_;
  }
}

void World::step_elastic_arm(int short_steps, bool ask_loop) {
  const WorldIndex& index = shared_->index;
  ElasticDrives::TorqueLoop loop;
  if (torque_loop_ && ask_loop) {
    loop = [this](const JointState& state) { return within_effort(torque_loop_(state)); };
  }
  const JointState before = sensors().joints;
  const ElasticDrives::Coupling coupling =
      drives_->begin_step(before.q, before.qd, model_->opt.timestep, short_steps, loop);
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const int dof = index.arm_dof[i];
    data_->qfrc_applied[dof] = coupling.torque[Eigen::Index(i)];
    model_->dof_armature[dof] =
        shared_->model->dof_armature[dof] + coupling.armature[Eigen::Index(i)];
  }
  step_physics();
  drives_->end_step(sensors().joints.qd);
}

// MuJoCo's friction lets a loaded contact creep; its noslip iterations forbid that, at a third of a
// step's time. Only an object that is gripped stays under load for long.
void World::drive_gripper() {
  const WorldIndex& index = shared_->index;
  const double width = data_->qpos[index.jaw_qpos[0]] + data_->qpos[index.jaw_qpos[1]];
  const double rate = data_->qvel[index.jaw_dof[0]] + data_->qvel[index.jaw_dof[1]];
  data_->ctrl[index.jaw_actuator] = gripper_.update(width, rate, kStep);
  const bool gripping = gripper_.closing_force() > kGrippingForce;
  model_->opt.noslip_iterations = gripping ? shared_->model->opt.noslip_iterations : 0;
}

// MuJoCo answers NaN and huge numbers with one warning and a silent reset of the whole world.
void World::check_step(double time_before) const {
  for (const int warning : {mjWARN_INERTIA, mjWARN_CONTACTFULL, mjWARN_CNSTRFULL, mjWARN_BADQPOS,
                            mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_BADCTRL}) {
    if (data_->warning[warning].number > 0) {
      throw SimulationDiverged(fmt::format("the simulation diverged at t = {:.3f} s: {}",
                                           time_before, last_mujoco_warning()));
    }
  }
  if (!(data_->time > time_before) || !all_finite(data_->qpos, model_->nq) ||
      !all_finite(data_->qvel, model_->nv)) {
    throw SimulationDiverged(fmt::format(
        "the simulation diverged at t = {:.3f} s: state not finite or time lost", time_before));
  }
}

void World::pin() {
  if (arm_held_) pin_arm();
  for (int i = 0; i < object_count(); ++i) {
    if (parked_[std::size_t(i)]) pin_object(i);
  }
}

void World::pin_arm() {
  const WorldIndex& index = shared_->index;
  JointVector weight;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    data_->qpos[index.arm_qpos[i]] = held_position_[Eigen::Index(i)];
    data_->qvel[index.arm_dof[i]] = 0.0;
    weight[Eigen::Index(i)] = data_->qfrc_bias[index.arm_dof[i]];
    data_->qfrc_applied[index.arm_dof[i]] = 0.0;
    // Sensors of a held arm read its weight.
    if (!drives_) data_->ctrl[index.arm_actuator[i]] = weight[Eigen::Index(i)];
  }
  if (drives_) drives_->reset(held_position_, weight);
}

void World::pin_object(int object) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().z() = kAway + 2.0 * object;
  set_object_pose(object, T);
  parked_[std::size_t(object)] = true;
}

JointVector World::within_effort(const JointVector& tau) const {
  JointVector limited;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const double effort = shared_->parts.arm.joints[i].effort;
    limited[Eigen::Index(i)] = std::clamp(tau[Eigen::Index(i)], -effort, effort);
  }
  return limited;
}

void World::set_arm_torques(const JointVector& tau) {
  if (arm_held_) return;
  if (drives_) {
    drives_->set_motor_torques(within_effort(tau));
    return;
  }
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    data_->ctrl[shared_->index.arm_actuator[i]] = tau[Eigen::Index(i)];
  }
}

RobotState World::sensors() const {
  const WorldIndex& index = shared_->index;
  RobotState state;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const auto joint = Eigen::Index(i);
    state.joints.q[joint] = data_->qpos[index.arm_qpos[i]];
    state.joints.qd[joint] = data_->qvel[index.arm_dof[i]];
    state.joints.tau[joint] = data_->qfrc_actuator[index.arm_dof[i]];
  }
  state.joints.theta = state.joints.q;
  state.joints.theta_d = state.joints.qd;
  if (drives_) {
    state.joints.tau = drives_->sensed_torque();
    state.joints.theta = drives_->theta();
    state.joints.theta_d = drives_->theta_d();
  }
  state.gripper.width = data_->qpos[index.jaw_qpos[0]] + data_->qpos[index.jaw_qpos[1]];
  state.gripper.force = gripper_.closing_force();
  return state;
}

void World::set_arm_position(const JointVector& q, double width) {
  const WorldIndex& index = shared_->index;
  held_position_ = q;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    data_->qpos[index.arm_qpos[i]] = q[Eigen::Index(i)];
    data_->qvel[index.arm_dof[i]] = 0.0;
  }
  for (std::size_t side = 0; side < 2; ++side) {
    data_->qpos[index.jaw_qpos[side]] = 0.5 * width;
    data_->qvel[index.jaw_dof[side]] = 0.0;
  }
  gripper_.reset(width);
  mj_forward(model_.get(), data_.get());
  pin();
  mj_forward(model_.get(), data_.get());
}

void World::hold_arm(bool held) {
  arm_held_ = held;
  if (held) held_position_ = sensors().joints.q;
  close_brakes(held);
  pin();
}

// A load would still move the joints within a step, before they are put back, and so creep along
// the arm's surface: closed brakes also make the joints immovably heavy.
void World::close_brakes(bool closed) {
  for (const int dof : shared_->index.arm_dof) {
    model_->dof_armature[dof] = closed ? kBrakeInertia : shared_->model->dof_armature[dof];
  }
}

void World::refresh_poses() {
  // mj_kinematics normalises quaternions in place, to other last bits: looking must not change the
  // world.
  const std::vector<mjtNum> qpos(data_->qpos, data_->qpos + model_->nq);
  mj_kinematics(model_.get(), data_.get());
  std::copy(qpos.begin(), qpos.end(), data_->qpos);
  mj_camlight(model_.get(), data_.get());
}

Eigen::Isometry3d World::T_world_tcp() {
  refresh_poses();
  const int site = shared_->index.tcp_site;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->site_xmat + 9 * site);
  T.translation() = Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * site);
  return T;
}

JointVector World::balancing_torques() {
  mj_fwdPosition(model_.get(), data_.get());
  mj_fwdVelocity(model_.get(), data_.get());
  JointVector torques;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    torques[Eigen::Index(i)] = data_->qfrc_bias[shared_->index.arm_dof[i]];
  }
  return torques;
}

void World::set_frame_present(bool present) {
  const int frame = shared_->index.frame_mocap;
  if (frame >= 0) data_->mocap_pos[3 * frame + 2] = present ? 0.0 : kAway;
}

void World::set_body_force(int body, const Eigen::Vector3d& force_world) {
  for (int axis = 0; axis < 3; ++axis) data_->xfrc_applied[6 * body + axis] = force_world[axis];
}

// Names each array of the state once, for saving and restoring.
template <class Visit>
void World::visit_state(Visit visit) const {
  visit(data_->qpos, model_->nq);
  visit(data_->qvel, model_->nv);
  visit(data_->act, model_->na);
  visit(data_->qacc_warmstart, model_->nv);
  visit(data_->ctrl, model_->nu);
  visit(data_->qfrc_applied, model_->nv);
  visit(data_->xfrc_applied, 6 * model_->nbody);
  visit(data_->mocap_pos, 3 * model_->nmocap);
  visit(data_->mocap_quat, 4 * model_->nmocap);
  // Not inputs of a step, but read between steps: sensor torques and the held arm's weight.
  visit(data_->qfrc_actuator, model_->nv);
  visit(data_->qfrc_bias, model_->nv);
}

WorldState World::save_state() const {
  WorldState state{data_->time, {}, gripper_, drives_, arm_held_, held_position_, parked_};
  visit_state([&](const mjtNum* values, int count) {
    state.numbers.insert(state.numbers.end(), values, values + count);
  });
  return state;
}

void World::restore_state(const WorldState& state) {
  std::size_t size = 0;
  visit_state([&](mjtNum*, int count) { size += static_cast<std::size_t>(count); });
  if (size != state.numbers.size() || drives_.has_value() != state.drives.has_value()) {
    throw std::invalid_argument("the state belongs to a world of another template or arm");
  }
  const double* next = state.numbers.data();
  visit_state([&](mjtNum* values, int count) {
    std::copy_n(next, count, values);
    next += count;
  });
  data_->time = state.time;
  gripper_ = state.gripper;
  drives_ = state.drives;
  arm_held_ = state.arm_held;
  close_brakes(arm_held_);
  held_position_ = state.held_position;
  parked_ = state.parked;
}

}  // namespace binpick
