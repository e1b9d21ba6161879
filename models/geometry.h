#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace binpick {

/// A closed interval [low, high].
struct Interval {
  double low = 0.0;
  double high = 0.0;

  [[nodiscard]] double centre() const noexcept { return 0.5 * (low + high); }
  [[nodiscard]] bool contains(double value) const noexcept { return low <= value && value <= high; }
};

/// Points in metres. `normals` is empty or as long as `points` (unit length, outward or towards the
/// sensor). An organised cloud has width * height == size and NaN where the sensor saw nothing; an
/// unorganised one has height == 1 (or 0 when empty).
struct PointCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  int width = 0;
  int height = 0;

  [[nodiscard]] bool organised() const noexcept { return height > 1; }
  [[nodiscard]] bool has_normals() const noexcept { return normals.size() == points.size(); }
};

/// Triangles with outward orientation (counter-clockwise seen from outside), metres.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

}  // namespace binpick
