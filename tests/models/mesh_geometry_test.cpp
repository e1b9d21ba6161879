#include "models/mesh_geometry.h"

#include <gtest/gtest.h>

#include "models/object_model.h"

namespace binpick {
namespace {

/// A closed box with outward triangles, shifted by `centre`.
TriangleMesh box_mesh(const Eigen::Vector3d& size, const Eigen::Vector3d& centre) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5);
    mesh.vertices.push_back(centre + corner.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TEST(MeshGeometry, BoxHasItsClosedFormProperties) {
  const Eigen::Vector3d size(0.2, 0.3, 0.5);
  const Eigen::Vector3d centre(1.0, -2.0, 0.5);
  const TriangleMesh mesh = box_mesh(size, centre);
  EXPECT_TRUE(is_watertight(mesh));
  EXPECT_NEAR(volume(mesh), 0.03, 1e-12);
  EXPECT_NEAR(area(mesh), 2 * (0.06 + 0.10 + 0.15), 1e-12);
  EXPECT_NEAR(bounding_diagonal(mesh), size.norm(), 1e-12);

  const MassProperties solid = solid_properties(mesh);
  EXPECT_LT((solid.com - centre).norm(), 1e-12);
  const Eigen::Vector3d expected = Eigen::Vector3d(0.09 + 0.25, 0.04 + 0.25, 0.04 + 0.09) / 12.0;
  EXPECT_LT((solid.inertia.diagonal() - expected).norm(), 1e-12);
  EXPECT_NEAR(solid.inertia(0, 1), 0.0, 1e-12);

  // Of a hollow cube with side s: 5 s^2 / 18.
  const MassProperties shell = shell_properties(box_mesh({0.6, 0.6, 0.6}, centre));
  EXPECT_LT((shell.com - centre).norm(), 1e-12);
  EXPECT_NEAR(shell.inertia(2, 2), 5.0 / 18.0 * 0.36, 1e-12);
}

TEST(MeshGeometry, HolesAndInwardTrianglesAreSeen) {
  TriangleMesh mesh = box_mesh({1, 1, 1}, Eigen::Vector3d::Zero());
  TriangleMesh turned = mesh;
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_FALSE(is_watertight(turned));
  TriangleMesh inward = mesh;
  for (auto& triangle : inward.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_LT(volume(inward), 0.0);
  mesh.triangles.pop_back();
  EXPECT_FALSE(is_watertight(mesh));
  EXPECT_FALSE(is_watertight(TriangleMesh{}));
}

TEST(MeshGeometry, SamplesLieOnTheSurfaceEvenlyByAreaWithItsNormals) {
  const Eigen::Vector3d size(0.2, 0.3, 0.5);
  const std::size_t count = 31000;
  const PointCloud cloud = sample_surface(box_mesh(size, Eigen::Vector3d::Zero()), count, 5);
  ASSERT_EQ(cloud.points.size(), count);
  ASSERT_TRUE(cloud.has_normals());
  std::size_t on_top = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f& n = cloud.normals[i];
    // The normal names the face; the point lies in its plane.
    EXPECT_NEAR(n.dot(cloud.points[i]), 0.5f * n.cwiseAbs().dot(size.cast<float>()), 1e-6f);
    on_top += n.z() > 0.5f ? 1u : 0u;
  }
  const double share = 0.06 / 0.62;
  EXPECT_NEAR(static_cast<double>(on_top), share * count,
              5 * std::sqrt(count * share * (1 - share)));
}

TEST(MeshGeometry, TheSameSeedGivesTheSameSamples) {
  const TriangleMesh mesh = box_mesh({1, 2, 3}, Eigen::Vector3d::Zero());
  EXPECT_EQ(sample_surface(mesh, 100, 1).points, sample_surface(mesh, 100, 1).points);
  EXPECT_NE(sample_surface(mesh, 100, 1).points, sample_surface(mesh, 100, 2).points);
}

}  // namespace
}  // namespace binpick
