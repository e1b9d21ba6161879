#include "recognition/recognition_model.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "models/errors.h"
#include "recognition/mesh_simplification.h"
#include "recognition/self_registration.h"
#include "recognition/surface_grid.h"
#include "recognition/surface_sampling.h"

namespace binpick {
namespace {

constexpr std::size_t kTestPoints = 512;
constexpr std::size_t kSurfaceSamples = 30000;
constexpr float kPairPointsPerDiameter = 18.0f;
constexpr float kDensePointsPerDiameter = 50.0f;
constexpr std::size_t kMostRenderTriangles = 12000;
constexpr double kRenderTolerance = 0.0015;  // of the diameter

/// Directions over half a sphere: those to the rim of a cube's surface grid.
std::vector<Eigen::Vector3f> half_directions() {
  std::vector<Eigen::Vector3f> all;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) {
        const bool on_cube = std::max({std::abs(x), std::abs(y), std::abs(z)}) == 2;
        const bool in_half = z > 0 || (z == 0 && (y > 0 || (y == 0 && x > 0)));
        if (!on_cube || !in_half) continue;
        all.push_back(Eigen::Vector3f(float(x), float(y), float(z)).normalized());
      }
    }
  }
  return all;
}

/// The farthest points in each of many directions.
std::vector<Eigen::Vector3f> extreme_points(const std::vector<Eigen::Vector3f>& points) {
  std::vector<Eigen::Vector3f> extremes;
  const auto add = [&](const Eigen::Vector3f& point) {
    const bool known =
        std::any_of(extremes.begin(), extremes.end(), [&](const auto& p) { return p == point; });
    if (!known) extremes.push_back(point);
  };
  for (const Eigen::Vector3f& direction : half_directions()) {
    std::size_t lowest = 0, highest = 0;
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const float along = points[i].dot(direction);
      if (along < low) {
        low = along;
        lowest = i;
      }
      if (along > high) {
        high = along;
        highest = i;
      }
    }
    add(points[highest]);
    add(points[lowest]);
  }
  return extremes;
}

/// The sides of the box along the principal axes, longest first.
Eigen::Vector3f fitted_box(const std::vector<OrientedPoint>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const OrientedPoint& point : points) mean += point.p.cast<double>();
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const OrientedPoint& point : points) {
    const Eigen::Vector3d d = point.p.cast<double>() - mean;
    covariance += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Matrix3f axes = solver.eigenvectors().cast<float>();
  // Principal axes of a near-square shape are arbitrary within the square; the model's own axes
  // often fit better. The smaller box counts.
  const auto box_along = [&](const Eigen::Matrix3f& frame) {
    Eigen::AlignedBox3f box;
    for (const OrientedPoint& point : points) box.extend(frame.transpose() * point.p);
    return Eigen::Vector3f(box.sizes());
  };
  const Eigen::Vector3f principal = box_along(axes);
  const Eigen::Vector3f own = box_along(Eigen::Matrix3f::Identity());
  Eigen::Vector3f sides = principal.prod() < own.prod() ? principal : own;
  std::sort(sides.data(), sides.data() + 3, std::greater<>());
  return sides;
}

std::vector<Eigen::Isometry3d> with_identity_first(
    const std::vector<Eigen::Isometry3d>& symmetries) {
  std::vector<Eigen::Isometry3d> all = {Eigen::Isometry3d::Identity()};
  for (const Eigen::Isometry3d& symmetry : symmetries) {
    if (!symmetry.isApprox(Eigen::Isometry3d::Identity(), 1e-9)) all.push_back(symmetry);
  }
  return all;
}

/// Fills in everything that follows from the surface: `dense` covers it, `outline` holds its
/// extreme points. Returns an even cover of spacing diameter / kDensePointsPerDiameter.
std::vector<OrientedPoint> fill_shape(RecognitionModel& model,
                                      const std::vector<OrientedPoint>& dense,
                                      const std::vector<Eigen::Vector3f>& outline,
                                      const std::vector<Eigen::Isometry3d>& symmetries) {
  model.hull = extreme_points(outline);
  for (const Eigen::Vector3f& a : model.hull) {
    for (const Eigen::Vector3f& b : model.hull) {
      model.diameter = std::max(model.diameter, (a - b).norm());
    }
  }
  Eigen::AlignedBox3f box;
  for (const OrientedPoint& point : dense) box.extend(point.p);
  model.centre = box.center();
  const Eigen::Vector3f sides = fitted_box(dense);
  model.middle_extent = sides[1];
  model.largest_face = sides[0] * sides[1];
  std::vector<OrientedPoint> uniform = thin_out(dense, model.diameter / kDensePointsPerDiameter);
  for (const OrientedPoint& point : uniform) {
    model.cover.push_back(point.p);
    model.cover_normals.push_back(point.n);
  }
  set_pair_points(model, kPairPointsPerDiameter);
  const std::vector<OrientedPoint> spread = spread_evenly(uniform, kTestPoints);
  for (const OrientedPoint& point : spread) {
    model.test_points.x.push_back(point.p.x());
    model.test_points.y.push_back(point.p.y());
    model.test_points.z.push_back(point.p.z());
    model.test_points.nx.push_back(point.n.x());
    model.test_points.ny.push_back(point.n.y());
    model.test_points.nz.push_back(point.n.z());
  }
  model.symmetries = symmetries.empty() ? find_symmetries(uniform, spread, model.diameter)
                                        : with_identity_first(symmetries);
  return uniform;
}

void add_normals(RenderMesh& mesh) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) {
      return mesh.vertices[static_cast<std::size_t>(triangle[i])];
    };
    const Eigen::Vector3f normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (!(normal.norm() > 0.0f)) continue;
    triangles.push_back(triangle);
    mesh.normals.push_back(normal.normalized());
  }
  mesh.triangles = std::move(triangles);
}

/// Merges the vertices within cells of a grid: a mesh of scanner resolution holds far more
/// triangles than an image of it has pixels.
TriangleMesh cluster_vertices(const TriangleMesh& mesh, double cell_size) {
  struct Cluster {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    std::int32_t index = 0;
  };
  std::unordered_map<std::uint64_t, Cluster> clusters;
  std::vector<std::int32_t> cluster_of;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.vertices) box.extend(p);
  const auto key_of = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d cell = (p - box.min()) / cell_size;
    const auto along = [&](int axis) { return static_cast<std::uint64_t>(cell[axis]) & 0x1fffffu; };
    return along(2) << 42 | along(1) << 21 | along(0);
  };
  for (const Eigen::Vector3d& p : mesh.vertices) {
    Cluster& cluster = clusters[key_of(p)];
    if (cluster.count == 0) cluster.index = static_cast<std::int32_t>(clusters.size()) - 1;
    cluster.sum += p;
    ++cluster.count;
    cluster_of.push_back(cluster.index);
  }
  TriangleMesh clustered;
  clustered.vertices.resize(clusters.size());
  for (const auto& [key, cluster] : clusters) {
    clustered.vertices[static_cast<std::size_t>(cluster.index)] = cluster.sum / cluster.count;
  }
  for (const auto& triangle : mesh.triangles) {
    const std::int32_t a = cluster_of[static_cast<std::size_t>(triangle[0])];
    const std::int32_t b = cluster_of[static_cast<std::size_t>(triangle[1])];
    const std::int32_t c = cluster_of[static_cast<std::size_t>(triangle[2])];
    if (a != b && b != c && c != a) clustered.triangles.push_back({a, b, c});
  }
  return clustered;
}

RenderMesh make_render_mesh(const TriangleMesh& mesh, float diameter) {
  const bool is_dense = mesh.triangles.size() > kMostRenderTriangles;
  const TriangleMesh coarse = simplify(is_dense ? cluster_vertices(mesh, diameter / 60.0) : mesh,
                                       kRenderTolerance * static_cast<double>(diameter));
  RenderMesh render;
  for (const Eigen::Vector3d& p : coarse.vertices) render.vertices.push_back(p.cast<float>());
  render.triangles = coarse.triangles;
  add_normals(render);
  return render;
}

/// Overlapping square tiles in the tangent planes: a surface for a cloud that has none.
RenderMesh make_tiles(const std::vector<OrientedPoint>& points, float spacing) {
  RenderMesh tiles;
  for (const OrientedPoint& point : points) {
    const Eigen::Vector3f a = 0.75f * spacing * point.n.unitOrthogonal();
    const Eigen::Vector3f b = point.n.cross(a);
    const auto first = static_cast<std::int32_t>(tiles.vertices.size());
    tiles.vertices.insert(tiles.vertices.end(),
                          {point.p - a - b, point.p + a - b, point.p + a + b, point.p - a + b});
    tiles.triangles.push_back({first, first + 1, first + 2});
    tiles.triangles.push_back({first, first + 2, first + 3});
  }
  add_normals(tiles);
  return tiles;
}

/// `cover` lies on the surface, `spacing` apart; measured within a few spacings.
void add_roughness(RenderMesh& mesh, const std::vector<OrientedPoint>& cover, float spacing) {
  const float radius = 3.0f * spacing;
  Eigen::AlignedBox3f box;
  for (const OrientedPoint& point : cover) box.extend(point.p);
  SurfaceGrid grid(box, radius);
  for (const OrientedPoint& point : cover) grid.add(point);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::Vector3f centroid = Eigen::Vector3f::Zero();
    for (const std::int32_t corner : mesh.triangles[t]) {
      centroid += mesh.vertices[static_cast<std::size_t>(corner)] / 3.0f;
    }
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float count = 0.0f;
    grid.any_near(centroid, [&](const OrientedPoint& point) {
      // What faces the other way is the far side of a thin part: never seen together.
      if ((point.p - centroid).squaredNorm() < radius * radius &&
          point.n.dot(mesh.normals[t]) > 0.0f) {
        sum += point.n;
        count += 1.0f;
      }
      return false;
    });
    const float length = count > 0.0f ? sum.norm() / count : 1.0f;
    mesh.roughness.push_back((1.0f - length) / (radius * radius));
  }
}

/// The sign of the enclosed volume tells an inside-out mesh; an open one keeps its orientation.
bool is_inside_out(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  constexpr double kLeastShare = 1e-4;  // of surface times diagonal: less is no volume
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t i) {
      return Eigen::Vector3d(mesh.vertices[static_cast<std::size_t>(t[i])] - box.center());
    };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
  }
  return volume < -kLeastShare * surface_area(mesh) * box.diagonal().norm();
}

struct FinitePoints {
  Eigen::AlignedBox3f box;
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
};

FinitePoints finite_points(const PointCloud& cloud) {
  FinitePoints extent;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite()) continue;
    if (cloud.has_normals() && !(cloud.normals[i].norm() > 0.5f)) continue;
    extent.box.extend(cloud.points[i]);
    extent.points.push_back(cloud.points[i]);
    if (cloud.has_normals()) extent.normals.push_back(cloud.normals[i].normalized());
  }
  return extent;
}

}  // namespace

RecognitionModel make_recognition_model(const std::string& name, const TriangleMesh& source,
                                        const std::vector<Eigen::Isometry3d>& symmetries) {
  TriangleMesh mesh = source;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.vertices) box.extend(p);
  if (mesh.triangles.empty() || !(surface_area(mesh) > 0.0) || !box.sizes().allFinite()) {
    throw InputError(
        fmt::format("model {}: the mesh has no surface; give one with triangles", name));
  }
  if (is_inside_out(mesh, box)) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  RecognitionModel model;
  model.name = name;
  std::vector<Eigen::Vector3f> corners;
  for (const auto& triangle : mesh.triangles) {
    for (const std::int32_t corner : triangle) {
      corners.push_back(mesh.vertices[static_cast<std::size_t>(corner)].cast<float>());
    }
  }
  const std::vector<OrientedPoint> uniform =
      fill_shape(model, sample_evenly(mesh, kSurfaceSamples), corners, symmetries);
  model.area = static_cast<float>(surface_area(mesh));
  model.render_mesh = make_render_mesh(mesh, model.diameter);
  add_roughness(model.render_mesh, uniform, model.diameter / kDensePointsPerDiameter);
  return model;
}

void set_pair_points(RecognitionModel& model, float points_per_diameter) {
  std::vector<OrientedPoint> cover;
  for (std::size_t i = 0; i < model.cover.size(); ++i) {
    cover.push_back({model.cover[i], model.cover_normals[i]});
  }
  model.surface = thin_out(cover, model.diameter / points_per_diameter);
}

RecognitionModel make_recognition_model(const std::string& name, const PointCloud& cloud,
                                        const std::vector<Eigen::Isometry3d>& symmetries) {
  FinitePoints extent = finite_points(cloud);
  const float diagonal = extent.points.empty() ? 0.0f : extent.box.diagonal().norm();
  if (extent.points.size() < 10 || !(diagonal > 0.0f)) {
    throw InputError(fmt::format(
        "model {}: the cloud has {} usable points and {} m of extent; give a denser one", name,
        extent.points.size(), diagonal));
  }
  if (extent.normals.empty()) {
    const bool about_origin = extent.box.contains(Eigen::Vector3f::Zero());
    const Eigen::Vector3f reference =
        about_origin ? Eigen::Vector3f(extent.box.center()) : Eigen::Vector3f(0.0f, 0.0f, 0.0f);
    extent.normals = estimate_normals(extent.points, diagonal / 30.0f, reference, about_origin);
  }
  std::vector<OrientedPoint> points;
  for (std::size_t i = 0; i < extent.points.size(); ++i) {
    points.push_back({extent.points[i], extent.normals[i]});
  }
  RecognitionModel model;
  model.name = name;
  const std::vector<OrientedPoint> uniform = fill_shape(model, points, extent.points, symmetries);
  // Every kept point stands for a hexagonal cell of the spacing at which it was kept.
  const float spacing = model.diameter / kDensePointsPerDiameter;
  model.area = 1.3f * spacing * spacing * static_cast<float>(uniform.size());
  model.render_mesh = make_tiles(uniform, 1.3f * spacing);
  add_roughness(model.render_mesh, uniform, spacing);
  return model;
}

}  // namespace binpick
