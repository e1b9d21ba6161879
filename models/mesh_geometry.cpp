#include "models/mesh_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace binpick {
namespace {

struct Triangle {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
  Eigen::Vector3d c;
};

Triangle triangle_of(const TriangleMesh& mesh, std::size_t index) {
  const auto& corners = mesh.triangles[index];
  return {mesh.vertices[static_cast<std::size_t>(corners[0])],
          mesh.vertices[static_cast<std::size_t>(corners[1])],
          mesh.vertices[static_cast<std::size_t>(corners[2])]};
}

double area(const Triangle& t) { return 0.5 * (t.b - t.a).cross(t.c - t.a).norm(); }

/// From the mean of p p^T over the body to the inertia of 1 kg about its com.
MassProperties from_moments(double extent, const Eigen::Vector3d& com,
                            const Eigen::Matrix3d& mean_square) {
  const Eigen::Matrix3d covariance = mean_square - com * com.transpose();
  return {extent, com, covariance.trace() * Eigen::Matrix3d::Identity() - covariance};
}

}  // namespace

double area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) sum += area(triangle_of(mesh, i));
  return sum;
}

double volume(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = triangle_of(mesh, i);
    sum += t.a.dot(t.b.cross(t.c)) / 6.0;
  }
  return sum;
}

MassProperties solid_properties(const TriangleMesh& mesh) {
  double total = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = triangle_of(mesh, i);
    const double tetrahedron = t.a.dot(t.b.cross(t.c)) / 6.0;
    const Eigen::Vector3d sum = t.a + t.b + t.c;
    total += tetrahedron;
    first += tetrahedron * sum / 4.0;
    // Over a tetrahedron with one corner in the origin, the mean of p p^T is
    // (sum sum^T + sum of v v^T) / 20.
    second += tetrahedron / 20.0 *
              (sum * sum.transpose() + t.a * t.a.transpose() + t.b * t.b.transpose() +
               t.c * t.c.transpose());
  }
  return from_moments(total, first / total, second / total);
}

MassProperties shell_properties(const TriangleMesh& mesh) {
  double total = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = triangle_of(mesh, i);
    const double face = area(t);
    const Eigen::Vector3d sum = t.a + t.b + t.c;
    total += face;
    first += face * sum / 3.0;
    second += face / 12.0 *
              (sum * sum.transpose() + t.a * t.a.transpose() + t.b * t.b.transpose() +
               t.c * t.c.transpose());
  }
  return from_moments(total, first / total, second / total);
}

Eigen::AlignedBox3d bounding_box(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

double bounding_diagonal(const TriangleMesh& mesh) { return bounding_box(mesh).diagonal().norm(); }

double lowest_point(const Eigen::Isometry3d& T_world_mesh, const TriangleMesh& mesh) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    lowest = std::min(lowest, (T_world_mesh * vertex).z());
  }
  return lowest;
}

bool is_watertight(const TriangleMesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> directed_edges;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      ++directed_edges[{triangle[k], triangle[(k + 1) % 3]}];
    }
  }
  return !directed_edges.empty() &&
         std::all_of(directed_edges.begin(), directed_edges.end(), [&](const auto& entry) {
           const auto opposite = directed_edges.find({entry.first.second, entry.first.first});
           return entry.second == 1 && opposite != directed_edges.end();
         });
}

PointCloud sample_surface(const TriangleMesh& mesh, std::size_t count, Seed seed) {
  std::vector<double> area_up_to(mesh.triangles.size());
  double total = 0.0;
  for (std::size_t i = 0; i < area_up_to.size(); ++i) {
    total += area(triangle_of(mesh, i));
    area_up_to[i] = total;
  }
  PointCloud cloud;
  if (total <= 0.0) return cloud;
  cloud.points.reserve(count);
  cloud.normals.reserve(count);
  Random random(seed);
  for (std::size_t i = 0; i < count; ++i) {
    const auto found =
        std::upper_bound(area_up_to.begin(), area_up_to.end(), random.uniform() * total);
    const std::size_t face =
        std::min(static_cast<std::size_t>(found - area_up_to.begin()), area_up_to.size() - 1);
    const Triangle t = triangle_of(mesh, face);
    // Uniform over a triangle (Osada et al., 2002).
    const double root = std::sqrt(random.uniform());
    const double along = random.uniform();
    const Eigen::Vector3d p = (1.0 - root) * t.a + root * (1.0 - along) * t.b + root * along * t.c;
    cloud.points.push_back(p.cast<float>());
    cloud.normals.push_back((t.b - t.a).cross(t.c - t.a).normalized().cast<float>());
  }
  cloud.width = static_cast<int>(count);
  cloud.height = count > 0 ? 1 : 0;
  return cloud;
}

}  // namespace binpick
