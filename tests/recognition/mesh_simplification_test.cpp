#include "recognition/mesh_simplification.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/mesh_geometry.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

TEST(MeshSimplification, ACylinderStaysOneWithinTheTolerance) {
  const TriangleMesh cylinder = testing::make_prism(200, 0.05, 0.1);
  const TriangleMesh simple = simplify(cylinder, 0.0005);
  EXPECT_LT(simple.triangles.size(), cylinder.triangles.size() / 3);
  EXPECT_TRUE(is_watertight(simple));
  for (const Eigen::Vector3d& p : simple.vertices) {
    EXPECT_NEAR(std::hypot(p.x(), p.y()), 0.05, 0.002);
    EXPECT_NEAR(std::abs(p.z()), 0.05, 0.001);
  }
  EXPECT_NEAR(volume(simple), volume(cylinder), 0.03 * volume(cylinder));
}

TEST(MeshSimplification, ABoxKeepsItsCorners) {
  const TriangleMesh box = testing::make_box({0.2, 0.1, 0.06});
  const TriangleMesh simple = simplify(box, 0.0005);
  EXPECT_EQ(simple.triangles.size(), 12u);
  EXPECT_NEAR(volume(simple), volume(box), 1e-9);
}

TEST(MeshSimplification, AnOpenSheetKeepsItsBorder) {
  TriangleMesh sheet;
  for (std::int32_t j = 0; j <= 10; ++j) {
    for (std::int32_t i = 0; i <= 10; ++i) {
      sheet.vertices.emplace_back(0.01 * i, 0.01 * j, 0.0);
      if (i == 10 || j == 10) continue;
      const std::int32_t a = 11 * j + i;
      sheet.triangles.push_back({a, a + 1, a + 12});
      sheet.triangles.push_back({a, a + 12, a + 11});
    }
  }
  const TriangleMesh simple = simplify(sheet, 0.0001);
  EXPECT_LT(simple.triangles.size(), 20u);
  EXPECT_NEAR(area(simple), 0.01, 1e-5);
}

}  // namespace
}  // namespace binpick
