#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "models/geometry.h"

namespace binpick {

/// What a point-cloud file holds, as it stands there: in the file's unit, nothing left out.
struct SurfaceData {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;  ///< empty or one per point, of any length
  std::vector<std::array<std::int32_t, 3>> triangles;
  int width = 0;  ///< organised when height > 1
  int height = 0;
};

/// In metres, with unit normals. What was not measured (a coordinate that is not finite, or a
/// normal without direction) is NaN in an organised cloud and left out of any other.
[[nodiscard]] PointCloud to_cloud(SurfaceData data, double unit);

/// The triangles, in metres: one vertex per place, none that no triangle uses, no triangle without
/// area. @throws InputError, naming `file`, for corners that do not exist or are not finite, and
/// when no triangle is left.
[[nodiscard]] TriangleMesh to_mesh(const SurfaceData& data, double unit, const std::string& file);

}  // namespace binpick
