#include "experiments/referee.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "recognition/pose_metrics.h"

namespace binpick {
namespace {

constexpr double kRestSpeed = 0.02;     // m/s
constexpr double kPlaceMargin = 0.005;  // of a place's border, m

const Container* container_for(const Scene& scene, const std::string& model) {
  for (const Container& container : scene.containers) {
    const auto& kinds = container.objects;
    if (std::find(kinds.begin(), kinds.end(), model) != kinds.end()) return &container;
  }
  return nullptr;
}

double largest_distance(const std::vector<Eigen::Vector3f>& points) {
  float squared = 0.0f;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      squared = std::max(squared, (points[i] - points[j]).squaredNorm());
    }
  }
  return std::sqrt(static_cast<double>(squared));
}

bool inside(const Eigen::Vector2d& p, const Eigen::Vector2d& centre, const Eigen::Vector2d& size,
            double margin) {
  return ((p - centre).cwiseAbs().array() <= (0.5 * size).array() + margin).all();
}

}  // namespace

Referee::Referee(const World& world) : world_(world), scene_(world.shared().parts.scene) {
  for (int i = 0; i < world.object_count(); ++i) {
    const TriangleMesh& mesh = world.object_model(i).mesh;
    Shape shape;
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      shape.points.push_back(vertex.cast<float>());
    }
    shape.diameter = largest_distance(shape.points);
    shapes_.push_back(std::move(shape));
  }
}

bool held_aloft(const World& world, int object, double height) {
  return world.object_between_pads(object) && !world.object_supported(object) &&
         world.object_lowest_point(object) > height;
}

bool Referee::in_designated_place(int object) const {
  const ObjectModel& model = world_.object_model(object);
  const Container* container = container_for(scene_, model.name);
  if (container == nullptr) return false;
  const Eigen::Vector3d p_world = world_.object_pose(object) * model.physics.p_model_com;
  const double highest_rest = container->wall_height + 2.0 * shapes_[std::size_t(object)].diameter;
  return inside(p_world.head<2>(), container->centre, container->size, kPlaceMargin) &&
         p_world.z() < highest_rest && world_.object_supported(object) &&
         !world_.object_between_pads(object) && world_.object_velocity(object).norm() < kRestSpeed;
}

std::vector<int> Referee::misplaced_objects() const {
  std::vector<int> misplaced;
  for (int i = 0; i < world_.object_count(); ++i) {
    if (!in_designated_place(i)) misplaced.push_back(i);
  }
  return misplaced;
}

std::vector<int> Referee::objects_in_pick_region() const {
  std::vector<int> found;
  for (int i = 0; i < world_.object_count(); ++i) {
    const Eigen::Vector3d p_world =
        world_.object_pose(i) * world_.object_model(i).physics.p_model_com;
    if (inside(p_world.head<2>(), scene_.pick_region_centre, scene_.pick_region_size, 0.0)) {
      found.push_back(i);
    }
  }
  return found;
}

std::optional<Referee::Match> Referee::match(const Detection& detection) const {
  std::optional<Match> best;
  for (int i = 0; i < world_.object_count(); ++i) {
    const ObjectModel& model = world_.object_model(i);
    if (model.name != detection.model) continue;
    const Shape& shape = shapes_[std::size_t(i)];
    const double distance =
        mssd(detection.T_scene_model, world_.object_pose(i), shape.points, model.symmetries);
    if (!best || distance < best->mssd) best = Match{i, distance, shape.diameter};
  }
  return best;
}

}  // namespace binpick
