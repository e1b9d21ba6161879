#include "scenes/scene.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

namespace binpick {
namespace {

constexpr double kReach = 1.2;  // no coordinate of the cell's contents lies further away, m

const NumberSpec kPosition{-kReach, kReach};
const NumberSpec kCameraPosition{-5.0, 5.0};
const NumberSpec kLength{0.001, 5.0};
const NumberSpec kAngle{-360.0, 360.0, kDegree};

void visit_count(ConfigVisitor& visitor, std::string_view key, int& value, int min, int max) {
  std::int64_t wide = value;
  visitor.integer(key, wide, min, max);
  value = static_cast<int>(wide);
}

struct Slot {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  void visit(ConfigVisitor& visitor) { visitor.vector("at", at, kPosition, Presence::kRequired); }
};

bool inside(const Eigen::Vector2d& point, const Eigen::Vector2d& centre,
            const Eigen::Vector2d& size) {
  return ((point - centre).cwiseAbs().array() <= 0.5 * size.array()).all();
}

}  // namespace

void Table::visit(ConfigVisitor& visitor) {
  visitor.vector("centre", centre, kPosition);
  visitor.vector("size", size, kLength);
  visitor.number("height", height, kLength);
}

void Container::visit(ConfigVisitor& visitor) {
  visitor.text("name", name, Presence::kRequired);
  visitor.texts("objects", objects, Presence::kRequired);
  visitor.vector("centre", centre, kPosition, Presence::kRequired);
  visitor.vector("size", size, kLength, Presence::kRequired);
  visitor.number("wall_height", wall_height, {0.0, 0.5});
  visitor.number("wall_thickness", wall_thickness, {0.005, 0.1});
  std::vector<Slot> places;
  for (const Eigen::Vector2d& slot : slots) places.push_back({slot});
  visitor.elements("slots", places);
  slots.clear();
  for (const Slot& place : places) slots.push_back(place.at);
}

CameraIntrinsics SceneCamera::intrinsics() const noexcept {
  // Pixel centres are whole numbers, so the image's middle lies half a pixel before width / 2.
  return {width, height, focal_length, focal_length, 0.5 * (width - 1), 0.5 * (height - 1)};
}

Eigen::Isometry3d SceneCamera::T_world_camera() const {
  const Eigen::Vector3d forward = (look_at - position).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.linear().col(0) = right;
  T_world_camera.linear().col(1) = forward.cross(right);
  T_world_camera.linear().col(2) = forward;
  T_world_camera.translation() = position;
  return T_world_camera;
}

void SceneCamera::visit(ConfigVisitor& visitor) {
  visit_count(visitor, "width", width, 16, 4096);
  visit_count(visitor, "height", height, 16, 4096);
  visitor.number("focal_length_px", focal_length, {10.0, 20000.0});
  visitor.vector("position", position, kCameraPosition);
  visitor.vector("look_at", look_at, kCameraPosition);
}

void ObjectSet::visit(ConfigVisitor& visitor) {
  visitor.text("model", model, Presence::kRequired);
  visit_count(visitor, "count", count, 1, 40);
}

Eigen::Matrix3d StandingObject::R_world_object() const {
  const double quarter = 0.5 * M_PI;
  Eigen::AngleAxisd up = Eigen::AngleAxisd(0.0, Eigen::Vector3d::UnitX());
  if (resting == "upside_down") up = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  if (resting == "x_up") up = Eigen::AngleAxisd(-quarter, Eigen::Vector3d::UnitY());
  if (resting == "y_up") up = Eigen::AngleAxisd(quarter, Eigen::Vector3d::UnitX());
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * up).toRotationMatrix();
}

void StandingObject::visit(ConfigVisitor& visitor) {
  visitor.text("model", model, Presence::kRequired);
  visitor.choice("resting", resting, {"upright", "upside_down", "x_up", "y_up"});
  visitor.vector("position", position, kPosition);
  visitor.number("yaw_deg", yaw, kAngle);
}

void PileRecipe::visit(ConfigVisitor& visitor) {
  visitor.vector("centre", centre, kPosition);
  visitor.number("frame_size", frame_size, {0.2, 1.0});
  visitor.number("frame_height", frame_height, {0.1, 1.0});
  visitor.number("frame_thickness", frame_thickness, {0.02, 0.5});
  visitor.number("drop_height", drop_height, {0.1, 2.0});
  visitor.number("drop_interval", drop_interval, {0.1, 5.0});
  visitor.number("settle_speed", settle_speed, {0.001, 0.2});
  visitor.number("settle_time", settle_time, {0.01, 5.0});
  visitor.number("settle_limit", settle_limit, {0.5, 60.0});
}

std::vector<std::string> Scene::object_names() const {
  std::vector<std::string> names;
  if (arrangement == "pile") {
    for (const ObjectSet& set : objects)
      names.insert(names.end(), std::size_t(set.count), set.model);
  } else {
    for (const StandingObject& object : standing) names.push_back(object.model);
  }
  return names;
}

std::vector<SceneProblem> Scene::validate() const {
  std::vector<SceneProblem> problems;
  if (object_names().empty()) {
    const std::string key = arrangement == "pile" ? "objects" : "standing";
    problems.push_back(
        {key, fmt::format("a {} scene needs at least one entry in '{}'", arrangement, key)});
  }
  for (const StandingObject& object : standing) {
    if (!inside(object.position, pick_region_centre, pick_region_size)) {
      problems.push_back(
          {"standing",
           fmt::format("'{}' stands outside the pick region; move it or enlarge the region",
                       object.model)});
    }
  }
  if (arrangement == "pile" && !inside(pile.centre, pick_region_centre, pick_region_size)) {
    problems.push_back({"pile", "the frame's centre lies outside the pick region"});
  }
  std::set<std::string> placed;
  for (const Container& container : containers) {
    if (inside(pick_region_centre, container.centre, container.size + pick_region_size)) {
      problems.push_back(
          {"containers", fmt::format("'{}' overlaps the pick region", container.name)});
    }
    for (const std::string& model : container.objects) {
      if (!placed.insert(model).second) {
        problems.push_back({"containers", fmt::format("'{}' belongs to two containers", model)});
      }
    }
    for (const Eigen::Vector2d& slot : container.slots) {
      if (!inside(slot, container.centre, container.size)) {
        problems.push_back(
            {"containers", fmt::format("a slot of '{}' lies outside it", container.name)});
      }
    }
  }
  const Eigen::Vector3d view = camera.look_at - camera.position;
  if (view.head<2>().norm() < 1e-6) {
    problems.push_back(
        {"camera", "the camera must not look straight up or down; move it aside by a millimetre"});
  }
  return problems;
}

void Scene::visit(ConfigVisitor& visitor) {
  visitor.text("extends", extends);
  visitor.group("table", [this](ConfigVisitor& inner) { table.visit(inner); });
  visitor.elements("containers", containers);
  visitor.group("pick_region", [this](ConfigVisitor& inner) {
    inner.vector("centre", pick_region_centre, kPosition);
    inner.vector("size", pick_region_size, kLength);
  });
  visitor.group("camera", [this](ConfigVisitor& inner) { camera.visit(inner); });
  visitor.group("picture", [this](ConfigVisitor& inner) {
    inner.vector("position", picture_position, kCameraPosition);
    inner.vector("look_at", picture_look_at, kCameraPosition);
  });
  visitor.vector("overview_deg", overview, {-170.0, 170.0, kDegree});
  visitor.number("transfer_height", transfer_height, {0.05, 1.0});
  visitor.choice("arrangement", arrangement, {"standing", "pile"});
  visitor.elements("objects", objects);
  visitor.elements("standing", standing);
  visitor.group("pile", [this](ConfigVisitor& inner) { pile.visit(inner); });
}

CellLayout cell_layout(const Scene& scene) {
  CellLayout layout;
  layout.pick_region = Eigen::AlignedBox2d(scene.pick_region_centre - 0.5 * scene.pick_region_size,
                                           scene.pick_region_centre + 0.5 * scene.pick_region_size);
  layout.overview = scene.overview;
  layout.transfer_height = scene.transfer_height;
  for (const Container& container : scene.containers) {
    Place place;
    place.name = container.name;
    place.objects = container.objects;
    place.slots = container.slots;
    if (place.slots.empty()) place.slots.push_back(container.centre);
    place.p_world = container.centre;
    place.size = container.size;
    place.floor_height = 0.0;
    place.rim_height = container.wall_height;
    layout.places.push_back(std::move(place));
  }
  return layout;
}

}  // namespace binpick
