#include "control/grasp_clearance.h"

#include <cmath>

#include "models/mesh_geometry.h"

namespace binpick {
namespace {

// Below this height over the table a point belongs to the table as the sensor sees it.
constexpr double kTableNoise = 0.01;
// Of a known object's surface: about one per 15 mm^2, as dense as the camera sees it.
constexpr std::size_t kSurfacePoints = 4000;
// In shadow is what lies this far behind the measured surface, m.
constexpr double kShadowDepth = 0.01;
// Where hidden_share looks: every so many metres along a finger, from its tip over this length.
constexpr double kFingerStep = 0.01;
constexpr int kFingerSteps = 7;

}  // namespace

GraspClearance::GraspClearance(RangeImage image, const GripperDescription& gripper,
                               double table_height, double margin, int least_points)
    : image_(std::move(image)),
      gripper_(gripper),
      table_height_(table_height),
      margin_(margin),
      least_points_(least_points) {
  for (int v = 0; v < image_.intrinsics.height; ++v) {
    for (int u = 0; u < image_.intrinsics.width; ++u) {
      if (!(image_.at(u, v) > 0.0f)) continue;
      const Eigen::Vector3d p_world = image_.T_world_camera * image_.p_camera(u, v);
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
  if (count < least_points_) count = 0;
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

double GraspClearance::hidden_share(const GraspPlan& plan) const {
  int hidden = 0;
  int all = 0;
  for (const double side : {-1.0, 1.0}) {
    for (const double across : {-0.5, 0.0, 0.5}) {
      for (const double outward : {0.0, 1.0}) {
        for (int step = 0; step < kFingerSteps; ++step, ++all) {
          const Eigen::Vector3d p_grasp(
              across * gripper_.pad_width,
              side * (0.5 * plan.grasp->pre_opening + outward * gripper_.finger_thickness),
              gripper_.tip_beyond_tcp - kFingerStep * step);
          if (in_shadow(plan.T_world_grasp * p_grasp)) ++hidden;
        }
      }
    }
  }
  return static_cast<double>(hidden) / all;
}

bool GraspClearance::in_shadow(const Eigen::Vector3d& p_world) const noexcept {
  if (p_world.z() < table_height_ + kTableNoise) return false;
  const Eigen::Vector3d p_camera = image_.T_world_camera.inverse() * p_world;
  if (p_camera.z() <= 0.0) return false;
  const CameraIntrinsics& k = image_.intrinsics;
  const auto u = std::lround(k.fx * p_camera.x() / p_camera.z() + k.cx);
  const auto v = std::lround(k.fy * p_camera.y() / p_camera.z() + k.cy);
  if (u < 0 || v < 0 || u >= k.width || v >= k.height) return false;
  const double measured = image_.at(static_cast<int>(u), static_cast<int>(v));
  return measured > 0.0 && measured < p_camera.z() - kShadowDepth;
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
