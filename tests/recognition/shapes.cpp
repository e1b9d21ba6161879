#include "recognition/shapes.h"

#include <cmath>
#include <cstdint>
#include <numbers>

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

std::vector<Eigen::Vector3d> ring(int sides, double radius, double z) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return points;
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
  return loft({ring(sides, radius, -0.5 * height), ring(sides, radius, 0.5 * height)});
}

TriangleMesh make_sphere(double radius) {
  constexpr int kLevels = 17;
  std::vector<std::vector<Eigen::Vector3d>> rings;
  for (int i = 1; i < kLevels; ++i) {
    const double latitude = std::numbers::pi * (static_cast<double>(i) / kLevels - 0.5);
    rings.push_back(ring(32, radius * std::cos(latitude), radius * std::sin(latitude)));
  }
  return loft(rings);
}

std::vector<ModelSource> known_objects() {
  std::vector<ModelSource> sources;
  for (const char* name : {"bottle", "amicelli", "rusk"}) {
    const ObjectModel object = load_known_object(name);
    sources.push_back({object.name, object.mesh, object.symmetries});
  }
  return sources;
}

}  // namespace binpick::testing
