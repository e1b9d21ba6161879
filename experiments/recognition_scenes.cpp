#include "experiments/recognition_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "experiments/recognition_objects.h"
#include "experiments/recognition_sensor.h"
#include "models/mesh_geometry.h"
#include "sim/physics_draw.h"
#include "sim/pile.h"

namespace binpick {
namespace {

constexpr int kSides = 36;
constexpr int kMostPiles = 20;
constexpr std::size_t kMostKeptPiles = 40;
constexpr std::size_t kSurfacePoints = 4000;
constexpr Seed kSurfaceSeed = 1;
/// A point is seen if it lies at most this behind the depth at its pixel, m, beyond what the slant
/// of the surface makes of half a pixel's diagonal.
constexpr float kDepthTolerance = 0.0015f;
constexpr float kSteepestSlant = 10.0f;

std::string pile_key(const RecognitionConditions& conditions, Seed seed) {
  return fmt::format("{} {} {}", fmt::join(conditions.objects, " "), conditions.frame_size, seed);
}

std::string camera_key(const RecognitionConditions& c) {
  return fmt::format("{} {} {} {} {} {} {} {} {} {}", c.camera_position.x(), c.camera_position.y(),
                     c.camera_position.z(), c.camera_look_at.x(), c.camera_look_at.y(),
                     c.camera_look_at.z(), c.width, c.height, c.focal_length, c.resolution);
}

/// Turns the world about the vertical through the pile's centre.
Eigen::Isometry3d turn(const Eigen::Vector2d& centre, int side) {
  const Eigen::Vector3d pivot(centre.x(), centre.y(), 0.0);
  const double angle = 2.0 * std::numbers::pi * side / kSides;
  return Eigen::Translation3d(pivot) * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
         Eigen::Translation3d(-pivot);
}

}  // namespace

SurfaceVisibility::SurfaceVisibility(const TriangleMesh& mesh)
    : points_(sample_surface(mesh, kSurfacePoints, kSurfaceSeed)) {}

void SurfaceVisibility::judge(const RangeImage& image, TrueObject& object) const {
  const Eigen::Isometry3f T = object.T_camera_model.cast<float>();
  const CameraIntrinsics& camera = image.intrinsics;
  const auto fx = static_cast<float>(camera.fx);
  const auto fy = static_cast<float>(camera.fy);
  const float half_pixel = 0.7071f / fx;
  int facing = 0;
  int seen = 0;
  for (std::size_t i = 0; i < points_.points.size(); ++i) {
    const Eigen::Vector3f p = T * points_.points[i];
    const float cosine = -(T.linear() * points_.normals[i]).dot(p) / p.norm();
    if (cosine <= 0.0f) continue;
    ++facing;
    const auto u = static_cast<int>(std::lround(fx * p.x() / p.z() + float(camera.cx)));
    const auto v = static_cast<int>(std::lround(fy * p.y() / p.z() + float(camera.cy)));
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const float slant = std::min(kSteepestSlant, std::sqrt(1.0f - cosine * cosine) / cosine);
    const float depth = image.at(u, v);
    if (depth > 0.0f && p.z() - depth < kDepthTolerance + half_pixel * p.z() * slant) ++seen;
  }
  object.occlusion = 1.0 - static_cast<double>(seen) / static_cast<double>(kSurfacePoints);
  object.visible_share = facing > 0 ? static_cast<double>(seen) / facing : 0.0;
}

RecognitionScenes::RecognitionScenes(const std::filesystem::path& scene_file)
    : scene_(load_scene(scene_file)) {}

Scene RecognitionScenes::scene_of(const RecognitionConditions& conditions) const {
  Scene scene = scene_;
  scene.arrangement = "pile";
  scene.pile.frame_size = conditions.frame_size;
  SceneCamera& camera = scene.camera;
  camera.position = conditions.camera_position;
  camera.look_at = conditions.camera_look_at;
  const auto scaled = [&](std::int64_t pixels) {
    return static_cast<int>(std::lround(conditions.resolution * static_cast<double>(pixels)));
  };
  camera.width = scaled(conditions.width);
  camera.height = scaled(conditions.height);
  camera.focal_length = conditions.resolution * conditions.focal_length;
  return scene;
}

RecognitionScenes::Studio& RecognitionScenes::studio(const RecognitionConditions& conditions) {
  const std::string key = pile_key(conditions, 0) + "|" + camera_key(conditions);
  Studio& studio = studios_[key];
  if (!studio.shared) {
    WorldParts parts;
    parts.scene = scene_of(conditions);
    parts.arm = load_lwr();
    parts.gripper = load_gripper();
    for (const std::string& name : conditions.objects) {
      parts.objects.push_back(recognition_object(name));
    }
    studio.shared = make_world_template(std::move(parts));
    studio.world =
        std::make_unique<World>(studio.shared, centre_physics(studio.shared->parts.objects));
    studio.world->set_frame_present(false);
    studio.camera = std::make_unique<DepthCamera>(studio.shared);
  }
  return studio;
}

RecognitionScenes::Pile& RecognitionScenes::pile(const RecognitionConditions& conditions,
                                                 Seed seed) {
  const std::string key = pile_key(conditions, seed);
  if (const auto found = piles_.find(key); found != piles_.end()) return found->second;
  if (piles_.size() >= kMostKeptPiles) piles_.clear();
  const std::shared_ptr<const WorldTemplate> shared = studio(conditions).shared;
  World world(shared, draw_physics(shared->parts.objects, derive_seed(seed, "physics")));
  const PileReport report = drop_pile(world, derive_seed(seed, "drop"));
  if (!report.settled || !report.outside.empty()) {
    throw std::runtime_error("the pile did not come to rest within the pick region");
  }
  Pile& pile = piles_[key];
  for (int i = 0; i < world.object_count(); ++i) pile.poses.push_back(world.object_pose(i));
  return pile;
}

const SurfaceVisibility& RecognitionScenes::visibility(const ObjectModel& object) {
  return visibilities_.try_emplace(object.name, object.mesh).first->second;
}

CleanView RecognitionScenes::look(const RecognitionConditions& conditions, const Pile& pile,
                                  int side) {
  Studio& place = studio(conditions);
  last_ = &place;
  const Eigen::Isometry3d T_turned_world = turn(scene_.pile.centre, side);
  CleanView view;
  for (std::size_t i = 0; i < pile.poses.size(); ++i) {
    place.world->set_object_pose(static_cast<int>(i), T_turned_world * pile.poses[i]);
  }
  view.image = place.camera->ideal(*place.world);
  const RangeImage measurable = lit(view.image, conditions);
  const Eigen::Isometry3d T_camera_world = view.image.T_world_camera.inverse();
  for (std::size_t i = 0; i < pile.poses.size(); ++i) {
    const ObjectModel& model = place.shared->parts.objects[i];
    TrueObject object;
    object.model = model.name;
    object.T_camera_model = T_camera_world * T_turned_world * pile.poses[i];
    visibility(model).judge(measurable, object);
    view.objects.push_back(object);
  }
  return view;
}

const std::vector<std::vector<double>>& RecognitionScenes::occlusions(
    const RecognitionConditions& conditions, Pile& pile) {
  auto& sides = pile.occlusions[camera_key(conditions) + " " + conditions.sensor];
  for (int side = static_cast<int>(sides.size()); side < kSides; ++side) {
    sides.emplace_back();
    for (const TrueObject& object : look(conditions, pile, side).objects) {
      sides.back().push_back(object.occlusion);
    }
  }
  return sides;
}

CleanView RecognitionScenes::view(const RecognitionConditions& conditions, Seed pile_seed) {
  if (conditions.target.empty()) return look(conditions, pile(conditions, pile_seed), 0);
  for (std::uint64_t attempt = 0; attempt < kMostPiles; ++attempt) {
    const Seed seed = derive_seed(pile_seed, attempt);
    Pile& dropped = pile(conditions, seed);
    const auto& sides = occlusions(conditions, dropped);
    const auto first = static_cast<int>(Random(derive_seed(seed, "side")).index(kSides));
    for (int k = 0; k < kSides; ++k) {
      const int side = (first + k) % kSides;
      for (std::size_t i = 0; i < conditions.objects.size(); ++i) {
        if (conditions.objects[i] != conditions.target) continue;
        const double off = sides[static_cast<std::size_t>(side)][i] - conditions.occlusion;
        if (std::abs(off) > conditions.occlusion_band) continue;
        CleanView view = look(conditions, dropped, side);
        view.target = static_cast<int>(i);
        return view;
      }
    }
  }
  throw std::runtime_error(fmt::format("no side of {} piles shows '{}' at an occlusion of {}",
                                       kMostPiles, conditions.target, conditions.occlusion));
}

SegmentationImage RecognitionScenes::segmentation() {
  const SceneCamera& camera = last_->shared->parts.scene.camera;
  return last_->camera->renderer().segmentation(*last_->world, View::kDepthCamera, camera.width,
                                                camera.height);
}

}  // namespace binpick
