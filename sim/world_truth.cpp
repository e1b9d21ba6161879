// The part of World that only the referee and the set-up of trials use.
#include <algorithm>
#include <limits>

#include "models/mesh_geometry.h"
#include "sim/world.h"

namespace binpick {
namespace {

constexpr double kTouch = 0.05;  // contact forces below are taken for numerical noise, N

}  // namespace

int World::object_count() const noexcept {
  return static_cast<int>(shared_->index.object_body.size());
}

const ObjectModel& World::object_model(int object) const {
  return shared_->parts.objects[std::size_t(object)];
}

Eigen::Isometry3d World::object_pose(int object) const {
  const mjtNum* q = data_->qpos + shared_->index.object_qpos[std::size_t(object)];
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(q[0], q[1], q[2]);
  T.linear() = Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized().toRotationMatrix();
  return T;
}

Eigen::Vector3d World::object_velocity(int object) const {
  return Eigen::Map<const Eigen::Vector3d>(data_->qvel +
                                           shared_->index.object_dof[std::size_t(object)]);
}

Eigen::Vector3d World::object_angular_velocity(int object) const {
  // MuJoCo gives a free joint's rotation in body axes.
  const mjtNum* v = data_->qvel + shared_->index.object_dof[std::size_t(object)];
  return object_pose(object).linear() * Eigen::Vector3d(v[3], v[4], v[5]);
}

void World::set_object_pose(int object, const Eigen::Isometry3d& T_world_model) {
  const WorldIndex& index = shared_->index;
  mjtNum* q = data_->qpos + index.object_qpos[std::size_t(object)];
  const Eigen::Quaterniond rotation(T_world_model.linear());
  const Eigen::Vector3d position = T_world_model.translation();
  const std::array<double, 7> pose{position.x(), position.y(), position.z(), rotation.w(),
                                   rotation.x(), rotation.y(), rotation.z()};
  std::copy(pose.begin(), pose.end(), q);
  const int dof = index.object_dof[std::size_t(object)];
  std::fill_n(data_->qvel + dof, 6, 0.0);
  std::fill_n(data_->qacc_warmstart + dof, 6, 0.0);
  parked_[std::size_t(object)] = false;
}

void World::park_object(int object) { pin_object(object); }

double World::object_lowest_point(int object) const {
  const Eigen::Isometry3d T = object_pose(object);
  double lowest = std::numeric_limits<double>::infinity();
  for (const TriangleMesh& piece : object_model(object).collision) {
    lowest = std::min(lowest, lowest_point(T, piece));
  }
  return lowest;
}

template <class Visit>
void World::visit_contacts(Visit visit) const {
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    if (contact.efc_address < 0) continue;
    std::array<mjtNum, 6> wrench{};
    mj_contactForce(model_.get(), data_.get(), i, wrench.data());
    visit(contact, wrench);
  }
}

std::array<double, 2> World::jaw_forces(int object) const {
  const WorldIndex& index = shared_->index;
  std::array<double, 2> forces{};
  visit_contacts([&](const mjContact& contact, const std::array<mjtNum, 6>& wrench) {
    for (const auto& [own, other] :
         {std::pair(contact.geom1, contact.geom2), std::pair(contact.geom2, contact.geom1)}) {
      if (index.geom_object[std::size_t(own)] != object) continue;
      for (std::size_t side = 0; side < 2; ++side) {
        const std::vector<int>& finger = index.finger_geoms[side];
        if (std::find(finger.begin(), finger.end(), other) != finger.end()) {
          forces[side] += wrench[0];
        }
      }
    }
  });
  return forces;
}

bool World::object_between_pads(int object) const {
  const std::array<double, 2> forces = jaw_forces(object);
  return std::min(forces[0], forces[1]) > kTouch;
}

bool World::object_supported(int object) const {
  const WorldIndex& index = shared_->index;
  bool supported = false;
  visit_contacts([&](const mjContact& contact, const std::array<mjtNum, 6>& wrench) {
    const int first = index.geom_object[std::size_t(contact.geom1)];
    const int second = index.geom_object[std::size_t(contact.geom2)];
    const bool touches = (first == object && second != WorldIndex::kRobot) ||
                         (second == object && first != WorldIndex::kRobot);
    supported = supported || (touches && wrench[0] > kTouch);
  });
  return supported;
}

Eigen::Vector3d World::contact_force_on_robot() const {
  const WorldIndex& index = shared_->index;
  Eigen::Vector3d total(0.0, 0.0, surface_ ? surface_force_ : 0.0);
  visit_contacts([&](const mjContact& contact, const std::array<mjtNum, 6>& wrench) {
    // The rows of the contact frame are its axes; the force is what geom1 does to geom2.
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(contact.frame);
    const Eigen::Vector3d force =
        axes.transpose() * Eigen::Vector3d(wrench[0], wrench[1], wrench[2]);
    if (index.geom_object[std::size_t(contact.geom2)] == WorldIndex::kRobot) total += force;
    if (index.geom_object[std::size_t(contact.geom1)] == WorldIndex::kRobot) total -= force;
  });
  return total;
}

}  // namespace binpick
