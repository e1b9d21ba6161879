#include "experiments/recognition_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <set>
#include <utility>

#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "models/model_file.h"
#include "sim/mesh_asset.h"

namespace binpick {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPatches = 6;
constexpr int kLloydSteps = 10;

fs::path toy_file(const std::string& name) { return models_directory() / "toys" / (name + ".ply"); }

std::size_t nearest(const std::vector<Eigen::Vector3d>& seeds, const Eigen::Vector3d& p) {
  const auto distance = [&](const Eigen::Vector3d& seed) { return (seed - p).squaredNorm(); };
  const auto found = std::min_element(seeds.begin(), seeds.end(),
                                      [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                                        return distance(a) < distance(b);
                                      });
  return static_cast<std::size_t>(found - seeds.begin());
}

/// Seeds of compact patches: the farthest points first, then Lloyd's iteration.
std::vector<Eigen::Vector3d> patch_seeds(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<Eigen::Vector3d> seeds{vertices.front()};
  while (seeds.size() < kPatches) {
    seeds.push_back(*std::max_element(
        vertices.begin(), vertices.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
          return (seeds[nearest(seeds, a)] - a).norm() < (seeds[nearest(seeds, b)] - b).norm();
        }));
  }
  for (int step = 0; step < kLloydSteps; ++step) {
    std::vector<Eigen::Vector4d> sums(seeds.size(), Eigen::Vector4d::Zero());
    for (const Eigen::Vector3d& p : vertices) sums[nearest(seeds, p)] += p.homogeneous();
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      if (sums[i].w() > 0.0) seeds[i] = sums[i].hnormalized();
    }
  }
  return seeds;
}

/// A part of a surface, closed by a cone from its rim to its middle: the physics takes its hull.
TriangleMesh closed_patch(const TriangleMesh& mesh,
                          const std::vector<std::array<std::int32_t, 3>>& triangles) {
  TriangleMesh patch;
  std::map<std::int32_t, std::int32_t> index;
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& triangle : triangles) {
    std::array<std::int32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, is_new] =
          index.try_emplace(triangle[k], static_cast<std::int32_t>(patch.vertices.size()));
      if (is_new) patch.vertices.push_back(mesh.vertices[static_cast<std::size_t>(triangle[k])]);
      corners[k] = at->second;
    }
    patch.triangles.push_back(corners);
    for (std::size_t k = 0; k < 3; ++k) edges.emplace(corners[k], corners[(k + 1) % 3]);
  }
  for (const Eigen::Vector3d& p : patch.vertices) middle += p;
  const auto apex = static_cast<std::int32_t>(patch.vertices.size());
  patch.vertices.emplace_back(middle / static_cast<double>(apex));
  for (const auto& [from, to] : edges) {
    if (!edges.contains({to, from})) patch.triangles.push_back({to, from, apex});
  }
  return patch;
}

std::vector<TriangleMesh> patches(const TriangleMesh& mesh) {
  const std::vector<Eigen::Vector3d> seeds = patch_seeds(mesh.vertices);
  std::vector<std::vector<std::array<std::int32_t, 3>>> triangles(seeds.size());
  for (const auto& triangle : mesh.triangles) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const std::int32_t corner : triangle) {
      centre += mesh.vertices[static_cast<std::size_t>(corner)] / 3.0;
    }
    triangles[nearest(seeds, centre)].push_back(triangle);
  }
  std::vector<TriangleMesh> result;
  for (const auto& patch : triangles) {
    if (!patch.empty()) result.push_back(closed_patch(mesh, patch));
  }
  return result;
}

TriangleMesh can_mesh() {
  constexpr int kCorners = 48;
  constexpr double kRadius = 0.033;
  constexpr double kHeight = 0.115;
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCorners;
    circle.emplace_back(kRadius * std::cos(angle), kRadius * std::sin(angle));
  }
  return prism(circle, kHeight);
}

/// Gives a bare mesh the mass and frictions of a toy or packaging; none of them is ever grasped.
ObjectModel passive_object(const std::string& name, TriangleMesh mesh,
                           std::vector<TriangleMesh> collision) {
  ObjectModel object;
  object.name = name;
  object.physics.mass = {0.2, 0.4};
  object.physics.table_friction = {0.2, 0.5};
  object.physics.object_friction = {0.2, 0.5};
  object.physics.pad_friction = {0.4, 0.9};
  const MassProperties solid = solid_properties(mesh);
  object.physics.p_model_com = solid.com;
  object.physics.inertia_per_mass = solid.inertia;
  object.symmetries = {Eigen::Isometry3d::Identity()};
  object.mesh = std::move(mesh);
  object.collision = std::move(collision);
  return object;
}

ObjectModel load_object(const std::string& name) {
  if (name == "can") return passive_object(name, can_mesh(), {can_mesh()});
  if (name == "carton") {
    const TriangleMesh box = box_mesh({0.070, 0.070, 0.195}, Eigen::Vector3d::Zero());
    return passive_object(name, box, {box});
  }
  if (const fs::path file = toy_file(name); fs::exists(file)) {
    auto mesh = std::get<TriangleMesh>(read_model_file(file));
    auto collision = patches(mesh);
    return passive_object(name, std::move(mesh), std::move(collision));
  }
  if (fs::exists(models_directory() / "objects" / name)) return load_known_object(name);
  throw InputError(
      fmt::format("'{}' is no object: name a folder of models/objects, a mesh of "
                  "models/toys, 'can' or 'carton'",
                  name));
}

}  // namespace

const ObjectModel& recognition_object(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, ObjectModel> objects;
  const std::scoped_lock lock(mutex);
  const auto found = objects.find(name);
  return found != objects.end() ? found->second
                                : objects.emplace(name, load_object(name)).first->second;
}

std::vector<fs::path> toy_files() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(models_directory() / "toys")) {
    if (entry.path().extension() == ".ply") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace binpick
