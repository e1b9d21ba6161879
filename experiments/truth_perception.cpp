#include "experiments/truth_perception.h"

#include <cmath>

#include "models/mesh_geometry.h"

namespace binpick {
namespace {

constexpr std::size_t kSurfacePoints = 2000;
constexpr double kLeastVisible = 0.10;
// Sensor noise and the edges of pixels: seen is what lies this near to the measured depth, m.
constexpr double kSameDepth = 0.01;

/// Whether the image shows this point of a surface at its place.
bool shows(const RangeImage& image, const Eigen::Vector3d& p_camera) {
  const CameraIntrinsics& k = image.intrinsics;
  const auto u = std::lround(k.fx * p_camera.x() / p_camera.z() + k.cx);
  const auto v = std::lround(k.fy * p_camera.y() / p_camera.z() + k.cy);
  if (u < 0 || v < 0 || u >= k.width || v >= k.height) return false;
  const double measured = image.at(static_cast<int>(u), static_cast<int>(v));
  return measured > 0.0 && std::abs(measured - p_camera.z()) < kSameDepth;
}

}  // namespace

TruthPerception::TruthPerception(const World& world) : world_(world) {
  for (int i = 0; i < world.object_count(); ++i) {
    surfaces_.push_back(
        sample_surface(world.object_model(i).mesh, kSurfacePoints, derive_seed(0, "surface")));
  }
}

std::vector<Detection> TruthPerception::recognize(const RangeImage& image) {
  std::vector<Detection> detections;
  for (int i = 0; i < world_.object_count(); ++i) {
    const PointCloud& surface = surfaces_[static_cast<std::size_t>(i)];
    const Eigen::Isometry3d T_camera_object =
        image.T_world_camera.inverse() * world_.object_pose(i);
    int facing = 0;
    int seen = 0;
    for (std::size_t k = 0; k < surface.points.size(); ++k) {
      const Eigen::Vector3d p_camera = T_camera_object * surface.points[k].cast<double>();
      const Eigen::Vector3d normal = T_camera_object.linear() * surface.normals[k].cast<double>();
      if (p_camera.z() <= 0.0 || normal.dot(p_camera) >= 0.0) continue;
      ++facing;
      if (shows(image, p_camera)) ++seen;
    }
    const double visibility = facing > 0 ? static_cast<double>(seen) / facing : 0.0;
    if (visibility < kLeastVisible) continue;
    Detection detection;
    detection.model = world_.object_model(i).name;
    detection.T_scene_model = world_.object_pose(i);
    detection.visibility = visibility;
    detection.explained_points = seen;
    detection.confidence = 1.0;
    detections.push_back(std::move(detection));
  }
  return detections;
}

}  // namespace binpick
