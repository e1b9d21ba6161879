#include "models/surface_data.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "models/errors.h"

namespace binpick {

PointCloud to_cloud(const SurfaceData& data, double unit) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const bool organised = data.height > 1;
  const bool with_normals = !data.normals.empty();
  PointCloud cloud;
  cloud.points.reserve(data.points.size());
  if (with_normals) cloud.normals.reserve(data.points.size());
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    Eigen::Vector3f point = (unit * data.points[i]).cast<float>();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    bool measured = point.allFinite();
    if (with_normals) {
      const double length = data.normals[i].norm();
      measured = measured && std::isfinite(length) && length > 0.0;
      if (measured) normal = (data.normals[i] / length).cast<float>();
    }
    if (!measured) {
      if (!organised) continue;
      point.setConstant(nan);
      normal.setConstant(nan);
    }
    cloud.points.push_back(point);
    if (with_normals) cloud.normals.push_back(normal);
  }
  cloud.width = organised ? data.width : static_cast<int>(cloud.points.size());
  cloud.height = organised ? data.height : (cloud.points.empty() ? 0 : 1);
  return cloud;
}

TriangleMesh to_mesh(const SurfaceData& data, double unit, const std::string& file) {
  TriangleMesh mesh;
  std::map<std::array<double, 3>, std::int32_t> index_of_place;
  const auto weld = [&](std::int32_t corner) {
    if (corner < 0 || static_cast<std::size_t>(corner) >= data.points.size()) {
      throw InputError(
          fmt::format("{}: a triangle names vertex {}, which does not exist; repair "
                      "the mesh",
                      file, corner));
    }
    const Eigen::Vector3d& point = data.points[static_cast<std::size_t>(corner)];
    if (!point.allFinite()) {
      throw InputError(fmt::format("{}: vertex {} is not finite; repair the mesh", file, corner));
    }
    // Adding zero makes -0 and 0 the same place.
    const auto [entry, inserted] =
        index_of_place.try_emplace({point.x() + 0.0, point.y() + 0.0, point.z() + 0.0},
                                   static_cast<std::int32_t>(mesh.vertices.size()));
    if (inserted) mesh.vertices.push_back(unit * point);
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
