#include "models/surface_data.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>

#include "models/errors.h"

namespace binpick {
namespace {

struct PlaceHash {
  std::size_t operator()(const Eigen::Vector3f& place) const noexcept {
    std::uint64_t hash = 0;
    for (const float coordinate : place) {
      // Adding zero makes -0 and 0 the same place.
      hash = (hash ^ std::bit_cast<std::uint32_t>(coordinate + 0.0f)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

}  // namespace

PointCloud to_cloud(SurfaceData data, double unit) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const bool organised = data.height > 1;
  const bool with_normals = !data.normals.empty();
  // In place: a cloud of ten million points is not held twice.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    Eigen::Vector3f point = data.points[i];
    if (unit != 1.0) point = (unit * point.cast<double>()).cast<float>();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    bool measured = point.allFinite();
    if (with_normals && measured) {
      const Eigen::Vector3d direction = data.normals[i].cast<double>();
      const double length = direction.norm();
      measured = std::isfinite(length) && length > 0.0;
      normal = (direction / length).cast<float>();
    }
    if (!measured) {
      if (!organised) continue;
      point.setConstant(kNan);
      normal.setConstant(kNan);
    }
    data.points[kept] = point;
    if (with_normals) data.normals[kept] = normal;
    ++kept;
  }
  data.points.resize(kept);
  if (with_normals) data.normals.resize(kept);
  PointCloud cloud;
  cloud.points = std::move(data.points);
  cloud.normals = std::move(data.normals);
  cloud.width = organised ? data.width : static_cast<int>(kept);
  cloud.height = organised ? data.height : (kept == 0 ? 0 : 1);
  return cloud;
}

TriangleMesh to_mesh(const SurfaceData& data, double unit, const std::string& file) {
  TriangleMesh mesh;
  std::unordered_map<Eigen::Vector3f, std::int32_t, PlaceHash> index_of_place;
  const auto weld = [&](std::int32_t corner) {
    if (corner < 0 || static_cast<std::size_t>(corner) >= data.points.size()) {
      throw InputError(
          fmt::format("{}: a triangle names vertex {}, which does not exist; repair "
                      "the mesh",
                      file, corner));
    }
    const Eigen::Vector3f& point = data.points[static_cast<std::size_t>(corner)];
    if (!point.allFinite()) {
      throw InputError(fmt::format("{}: vertex {} is not finite; repair the mesh", file, corner));
    }
    const auto [entry, inserted] =
        index_of_place.try_emplace(point, static_cast<std::int32_t>(mesh.vertices.size()));
    if (inserted) mesh.vertices.push_back(unit * point.cast<double>());
    return entry->second;
  };
  for (const auto& corners : data.triangles) {
    const std::array<std::int32_t, 3> triangle{weld(corners[0]), weld(corners[1]),
                                               weld(corners[2])};
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(triangle[0])];
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(triangle[1])];
    const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(triangle[2])];
    if ((b - a).cross(c - a).squaredNorm() > 0.0) mesh.triangles.push_back(triangle);
  }
  if (mesh.triangles.empty()) {
    throw InputError(fmt::format("{}: no triangles; give a mesh with a surface", file));
  }
  return mesh;
}

}  // namespace binpick
