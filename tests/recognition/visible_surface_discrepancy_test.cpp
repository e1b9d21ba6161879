#include "recognition/visible_surface_discrepancy.h"

#include <gtest/gtest.h>

#include "recognition/depth_rasterizer.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

/// A square of 0.2 m that faces a camera of 100 pixels per unit tangent, at z = 1: 20 x 20 pixels.
struct Plate {
  Plate() {
    mesh.vertices = {
        {-0.1f, -0.1f, 0.0f}, {0.1f, -0.1f, 0.0f}, {0.1f, 0.1f, 0.0f}, {-0.1f, 0.1f, 0.0f}};
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    mesh.normals.assign(2, -Eigen::Vector3f::UnitZ());
    truth.translation().z() = 1.0;
  }
  [[nodiscard]] Eigen::Isometry3d moved(double x, double z) const {
    Eigen::Isometry3d T = truth;
    T.translation() += Eigen::Vector3d(x, 0.0, z);
    return T;
  }
  RenderMesh mesh;
  Projection projection{60, 60, 100.0f, 100.0f, 29.5f, 29.5f};
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  std::vector<float> empty = std::vector<float>(3600, 0.0f);
};

TEST(VisibleSurfaceDiscrepancy, CountsWhatTheTwoPosesShareNot) {
  const Plate plate;
  const auto vsd = [&](const Eigen::Isometry3d& T, const std::vector<float>& depth) {
    return visible_surface_discrepancy(T, plate.truth, plate.mesh, depth, plate.projection);
  };
  EXPECT_EQ(vsd(plate.truth, plate.empty), 0.0);
  // Half a width to the side: 10 of 30 columns are common.
  EXPECT_NEAR(vsd(plate.moved(0.1, 0.0), plate.empty), 2.0 / 3.0, 1e-6);
  // Farther back than the tolerance: nothing agrees. Nearer than it: all that is common does.
  EXPECT_EQ(vsd(plate.moved(0.0, 0.012), plate.empty), 1.0);
  EXPECT_NEAR(vsd(plate.moved(0.0, 0.005), plate.empty), 0.0, 0.25);
}

TEST(VisibleSurfaceDiscrepancy, WhatIsHiddenDoesNotCount) {
  const Plate plate;
  // Something at 0.5 m hides the columns to the right of the middle.
  std::vector<float> depth = plate.empty;
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = i % 60 >= 30 ? 0.5f : 1.0f;
  // Visible: 10 columns of the truth, 20 of the estimate to the left, none common.
  EXPECT_NEAR(visible_surface_discrepancy(plate.moved(-0.2, 0.0), plate.truth, plate.mesh, depth,
                                          plate.projection),
              1.0, 1e-6);
  // Half a width to the left: 10 columns of each are visible beyond the common 10.
  EXPECT_NEAR(visible_surface_discrepancy(plate.moved(-0.1, 0.0), plate.truth, plate.mesh, depth,
                                          plate.projection),
              0.5, 1e-6);
  // All hidden.
  depth.assign(3600, 0.5f);
  EXPECT_EQ(
      visible_surface_discrepancy(plate.truth, plate.truth, plate.mesh, depth, plate.projection),
      1.0);
}

}  // namespace
}  // namespace binpick
