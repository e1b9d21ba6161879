#include "control/grasp_clearance.h"

#include <cmath>

#include "models/mesh_geometry.h"

namespace binpick {
namespace {

// Below this height over the table a point belongs to the table as the sensor sees it.
constexpr double kTableNoise = 0.01;
// Of a known object's surface: about one per 15 mm^2, as dense as the camera sees it.
constexpr std::size_t kSurfacePoints = 4000;

}  // namespace

GraspClearance::GraspClearance(const RangeImage& image, const GripperDescription& gripper,
                               double table_height, double margin)
    : gripper_(gripper), margin_(margin) {
  for (int v = 0; v < image.intrinsics.height; ++v) {
    for (int u = 0; u < image.intrinsics.width; ++u) {
      if (!(image.at(u, v) > 0.0f)) continue;
      const Eigen::Vector3d p_world = image.T_world_camera * image.p_camera(u, v);
      if (p_world.z() > table_height + kTableNoise) points_world_.push_back(p_world);
    }
  }
}

void GraspClearance::add_object(const Detection& detection, const ObjectModel& object) {
  KnownObject known{detection, {}};
  for (const Eigen::Vector3f& p_model :
       sample_surface(object.mesh, kSurfacePoints, derive_seed(0, object.name)).points) {
    known.points_world.push_back(detection.T_scene_model * p_model.cast<double>());
  }
  objects_.push_back(std::move(known));
}

std::vector<Eigen::Vector3d> GraspClearance::points_within(
    const Eigen::AlignedBox2d& region) const {
  std::vector<Eigen::Vector3d> inside;
  for (const Eigen::Vector3d& p_world : points_world_) {
    if (region.contains(Eigen::Vector2d(p_world.head<2>()))) inside.push_back(p_world);
  }
  return inside;
}

int GraspClearance::obstructing_points(const GraspPlan& plan, double own_margin) const {
  const Eigen::AlignedBox3d tight = bounding_box(plan.object->mesh);
  const Eigen::Vector3d grown = Eigen::Vector3d::Constant(own_margin);
  const Eigen::AlignedBox3d own(tight.min() - grown, tight.max() + grown);
  const Eigen::Isometry3d T_grasp_world = plan.T_world_grasp.inverse();
  const Eigen::Isometry3d T_object_world = plan.detection.T_scene_model.inverse();
  int count = 0;
  for (const Eigen::Vector3d& p_world : points_world_) {
    if (in_swept_gripper(T_grasp_world * p_world, plan.grasp->pre_opening) &&
        !own.contains(T_object_world * p_world)) {
      ++count;
    }
  }
  for (const KnownObject& known : objects_) {
    const bool target = known.detection.model == plan.detection.model &&
                        known.detection.T_scene_model.isApprox(plan.detection.T_scene_model);
    if (target) continue;
    for (const Eigen::Vector3d& p_world : known.points_world) {
      if (in_swept_gripper(T_grasp_world * p_world, plan.grasp->pre_opening)) ++count;
    }
  }
  return count;
}

bool GraspClearance::in_swept_gripper(const Eigen::Vector3d& p_grasp,
                                      double opening) const noexcept {
  // Moving forward along z, whatever lies behind a part's front face will be swept by it.
  const double x = std::abs(p_grasp.x());
  const double y = std::abs(p_grasp.y());
  const double z = p_grasp.z();
  const double reach_back = gripper_.T_flange_tcp.translation().z();
  if (z < -reach_back) return false;
  const double finger_inside = 0.5 * opening - margin_;
  const double finger_outside = 0.5 * opening + gripper_.finger_thickness + margin_;
  const bool in_finger = x < 0.5 * gripper_.pad_width + margin_ && y > finger_inside &&
                         y < finger_outside && z < gripper_.tip_beyond_tcp + margin_;
  const double housing_front = gripper_.tip_beyond_tcp - gripper_.finger_length;
  const bool in_housing = x < 0.5 * gripper_.body_size.x() + margin_ &&
                          y < 0.5 * gripper_.body_size.y() + margin_ && z < housing_front + margin_;
  return in_finger || in_housing;
}

}  // namespace binpick
