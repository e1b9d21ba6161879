#include "recognition/surface_sampling.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "recognition/scene_octree.h"
#include "recognition/surface_grid.h"

namespace binpick {
namespace {

Eigen::Vector3d scaled_normal(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& t) {
  const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
  return 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0));
}

std::uint64_t spread_bits(std::uint64_t value) {
  std::uint64_t spread = 0;
  for (int bit = 0; bit < 10; ++bit) spread |= ((value >> bit) & 1u) << (3 * bit);
  return spread;
}

std::uint32_t reverse_bits(std::uint32_t value, int bits) {
  std::uint32_t reversed = 0;
  for (int bit = 0; bit < bits; ++bit) reversed |= ((value >> bit) & 1u) << (bits - 1 - bit);
  return reversed;
}

/// Along a space-filling (Morton) curve every k-th point covers the surface; visiting the curve in
/// bit-reversed order makes every prefix such a selection.
std::vector<OrientedPoint> order_by_uniform_prefixes(const std::vector<OrientedPoint>& points) {
  Eigen::AlignedBox3f box;
  for (const OrientedPoint& point : points) box.extend(point.p);
  const float scale = 1023.0f / std::max(box.sizes().maxCoeff(), 1e-12f);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> curve;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f cell = (points[i].p - box.min()) * scale;
    const std::uint64_t code = spread_bits(static_cast<std::uint64_t>(cell.x())) |
                               spread_bits(static_cast<std::uint64_t>(cell.y())) << 1 |
                               spread_bits(static_cast<std::uint64_t>(cell.z())) << 2;
    curve.emplace_back(code, i);
  }
  std::sort(curve.begin(), curve.end());
  int bits = 0;
  while ((std::size_t{1} << bits) < points.size()) ++bits;
  std::vector<OrientedPoint> ordered;
  ordered.reserve(points.size());
  for (std::uint32_t i = 0; i < (1u << bits); ++i) {
    const std::uint32_t position = reverse_bits(i, bits);
    if (position < curve.size()) ordered.push_back(points[curve[position].second]);
  }
  return ordered;
}

}  // namespace

double surface_area(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const auto& triangle : mesh.triangles) area += scaled_normal(mesh, triangle).norm();
  return area;
}

std::vector<OrientedPoint> sample_evenly(const TriangleMesh& mesh, std::size_t count) {
  std::vector<double> cumulated;
  cumulated.reserve(mesh.triangles.size());
  double area = 0.0;
  for (const auto& triangle : mesh.triangles) {
    area += scaled_normal(mesh, triangle).norm();
    cumulated.push_back(area);
  }
  std::vector<OrientedPoint> points;
  if (!(area > 0.0)) return points;
  points.reserve(count);
  // The additive recurrence of the plastic number's powers (R2, Roberts 2018) inside triangles.
  constexpr double kPlastic1 = 0.7548776662466927;
  constexpr double kPlastic2 = 0.5698402909980532;
  const auto fraction = [](double x) { return x - static_cast<double>(static_cast<long>(x)); };
  std::size_t index = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double target = area * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    while (cumulated[index] < target && index + 1 < cumulated.size()) ++index;
    const auto& triangle = mesh.triangles[index];
    double a = fraction(0.5 + kPlastic1 * static_cast<double>(i));
    double b = fraction(0.5 + kPlastic2 * static_cast<double>(i));
    if (a + b > 1.0) {
      a = 1.0 - a;
      b = 1.0 - b;
    }
    const Eigen::Vector3d& origin = mesh.vertices[static_cast<std::size_t>(triangle[0])];
    const Eigen::Vector3d p = origin +
                              a * (mesh.vertices[static_cast<std::size_t>(triangle[1])] - origin) +
                              b * (mesh.vertices[static_cast<std::size_t>(triangle[2])] - origin);
    points.push_back({p.cast<float>(), scaled_normal(mesh, triangle).normalized().cast<float>()});
  }
  return points;
}

std::vector<OrientedPoint> thin_out(const std::vector<OrientedPoint>& points, float spacing) {
  // Both sides of a sharp edge or a thin wall are kept: they carry different normals.
  constexpr float kLikeOrientation = 0.7f;
  Eigen::AlignedBox3f box;
  for (const OrientedPoint& point : points) box.extend(point.p);
  if (points.empty()) return {};
  SurfaceGrid kept(box, spacing);
  // A fixed stride visits the points in scattered order; taken in order they would form rows.
  const std::size_t size = points.size();
  std::size_t stride = static_cast<std::size_t>(0.6180339887 * static_cast<double>(size)) | 1u;
  while (std::gcd(stride, size) != 1) stride += 2;
  for (std::size_t step = 0, i = 0; step < size; ++step, i = (i + stride) % size) {
    const OrientedPoint& candidate = points[i];
    const bool crowded = kept.any_near(candidate.p, [&](const OrientedPoint& other) {
      return (other.p - candidate.p).squaredNorm() < spacing * spacing &&
             other.n.dot(candidate.n) > kLikeOrientation;
    });
    if (!crowded) kept.add(candidate);
  }
  return kept.points();
}

std::vector<OrientedPoint> spread_evenly(const std::vector<OrientedPoint>& points,
                                         std::size_t count) {
  if (points.size() <= count) return order_by_uniform_prefixes(points);
  // Coordinates side by side: one pass updates the distances, another finds the farthest point.
  const std::size_t size = points.size();
  std::vector<float> x(size), y(size), z(size);
  for (std::size_t i = 0; i < size; ++i) {
    x[i] = points[i].p.x();
    y[i] = points[i].p.y();
    z[i] = points[i].p.z();
  }
  std::vector<float> distance(size, std::numeric_limits<float>::max());
  std::vector<OrientedPoint> chosen;
  chosen.reserve(count);
  std::size_t next = 0;
  while (chosen.size() < count) {
    chosen.push_back(points[next]);
    const float px = x[next], py = y[next], pz = z[next];
    for (std::size_t i = 0; i < size; ++i) {
      const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
      const float squared = dx * dx + dy * dy + dz * dz;
      distance[i] = squared < distance[i] ? squared : distance[i];
    }
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) -
                                    distance.begin());
  }
  return order_by_uniform_prefixes(chosen);
}

std::vector<Eigen::Vector3f> estimate_normals(const std::vector<Eigen::Vector3f>& points,
                                              float radius, const Eigen::Vector3f& towards,
                                              bool outward) {
  const SceneOctree octree(points, radius / 1.5f);
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    const int leaf = octree.leaf_at(p);
    Eigen::Vector3f normal = leaf < 0 ? Eigen::Vector3f::UnitZ() : octree.plane_at(leaf).normal;
    const bool faces = normal.dot(towards - p) > 0.0f;
    if (faces == outward) normal = -normal;
    normals.push_back(normal);
  }
  return normals;
}

}  // namespace binpick
