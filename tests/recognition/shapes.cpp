#include "recognition/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>

#include "models/errors.h"
#include "models/mesh_import.h"
#include "models/object_model.h"

namespace binpick::testing {
namespace {

/// A body of revolution-like rings, closed by fans: rings[i] has `sides` points.
TriangleMesh loft(const std::vector<std::vector<Eigen::Vector3d>>& rings) {
  TriangleMesh mesh;
  const auto sides = static_cast<std::int32_t>(rings.front().size());
  for (const auto& ring : rings) {
    mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  }
  const auto levels = static_cast<std::int32_t>(rings.size());
  for (std::int32_t level = 0; level + 1 < levels; ++level) {
    for (std::int32_t i = 0; i < sides; ++i) {
      const std::int32_t a = level * sides + i;
      const std::int32_t b = level * sides + (i + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  }
  const std::int32_t top = (levels - 1) * sides;
  for (std::int32_t i = 1; i + 1 < sides; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({top, top + i, top + i + 1});
  }
  return mesh;
}

std::vector<Eigen::Vector3d> ring(int sides, const RingProfile& at) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    points.emplace_back(at.a * std::cos(angle), at.b * std::sin(angle), at.z);
  }
  return points;
}

/// The turns about z by multiples of a full turn over `count`.
std::vector<Eigen::Isometry3d> turns(int count) {
  std::vector<Eigen::Isometry3d> group;
  for (int i = 0; i < count; ++i) {
    group.emplace_back(
        Eigen::AngleAxisd(2.0 * std::numbers::pi * i / count, Eigen::Vector3d::UnitZ()));
  }
  return group;
}

}  // namespace

TriangleMesh make_box(const Eigen::Vector3d& size) {
  const Eigen::Vector3d h = 0.5 * size;
  const auto level = [&](double z) {
    return std::vector<Eigen::Vector3d>{
        {-h.x(), -h.y(), z}, {h.x(), -h.y(), z}, {h.x(), h.y(), z}, {-h.x(), h.y(), z}};
  };
  return loft({level(-h.z()), level(h.z())});
}

TriangleMesh make_prism(int sides, double radius, double height) {
  return make_loft({{-0.5 * height, radius, radius}, {0.5 * height, radius, radius}}, sides);
}

TriangleMesh make_sphere(double radius) {
  constexpr int kLevels = 17;
  std::vector<RingProfile> profile;
  for (int i = 1; i < kLevels; ++i) {
    const double latitude = std::numbers::pi * (static_cast<double>(i) / kLevels - 0.5);
    const double r = radius * std::cos(latitude);
    profile.push_back({radius * std::sin(latitude), r, r});
  }
  return make_loft(profile, 32);
}

TriangleMesh make_loft(const std::vector<RingProfile>& profile, int sides) {
  std::vector<std::vector<Eigen::Vector3d>> rings;
  for (const RingProfile& at : profile) rings.push_back(ring(sides, at));
  return loft(rings);
}

TriangleMesh make_cup(double radius, double height, double thickness, int sides) {
  // The wall's thickness is measured across the flats.
  const double inner = radius - thickness / std::cos(std::numbers::pi / sides);
  return make_loft({{0.0, radius, radius},
                    {height, radius, radius},
                    {height, inner, inner},
                    {thickness, inner, inner}},
                   sides);
}

std::vector<ModelSource> known_objects() {
  std::vector<ModelSource> sources;
  for (const char* name : {"bottle", "amicelli", "rusk"}) {
    const ObjectModel object = load_known_object(name);
    sources.push_back({object.name, object.mesh, object.symmetries});
  }
  return sources;
}

std::vector<ModelSource> toy_objects() {
  const std::filesystem::path folder = models_directory() / "toys";
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".ply") files.push_back(entry.path());
    }
  }
  if (files.empty()) throw InputError(folder.string() + ": no toy (*.ply) is there");
  std::sort(files.begin(), files.end());
  std::vector<ModelSource> sources;
  for (const auto& file : files) sources.push_back({file.stem().string(), import_mesh(file)});
  return sources;
}

std::vector<ModelSource> open_objects() {
  const TriangleMesh bowl = make_loft({{0.0, 0.035, 0.035},
                                       {0.02, 0.06, 0.06},
                                       {0.06, 0.085, 0.085},
                                       {0.06, 0.082, 0.082},
                                       {0.022, 0.057, 0.057},
                                       {0.003, 0.033, 0.033}},
                                      48);
  return {{"cup", make_cup(0.04, 0.1, 0.003, 48), turns(48)},
          {"bowl", bowl, turns(48)},
          {"open_box", make_cup(0.1, 0.08, 0.003, 4), turns(4)}};
}

std::vector<ModelSource> object_set(const std::string& name) {
  if (name == "known") return known_objects();
  if (name == "toys") return toy_objects();
  if (name == "open") return open_objects();
  throw InputError("no set of objects is called '" + name + "'; choose known, toys or open");
}

}  // namespace binpick::testing
