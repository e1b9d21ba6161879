#include "recognition/support_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/random.h"
#include "recognition/observed_scene.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

/// Points of a rectangle at `centre` spanned by the two sides, with noise along its normal.
void add_rectangle(std::vector<Eigen::Vector3f>& points, const Eigen::Vector3d& centre,
                   const Eigen::Vector3d& side_a, const Eigen::Vector3d& side_b, double spacing,
                   Random& random) {
  const Eigen::Vector3d normal = side_a.cross(side_b).normalized();
  for (double a = -0.5; a < 0.5; a += spacing / side_a.norm()) {
    for (double b = -0.5; b < 0.5; b += spacing / side_b.norm()) {
      points.push_back(
          (centre + a * side_a + b * side_b + 0.001 * random.normal() * normal).cast<float>());
    }
  }
}

SupportPlaneOptions options() {
  SupportPlaneOptions o;
  o.least_area = 0.05;
  return o;
}

constexpr float kLeaf = 0.006f;

TEST(SupportPlane, FindsATableAndItsPose) {
  Random random(1);
  std::vector<Eigen::Vector3f> points;
  const Eigen::Vector3d tilted = Eigen::Vector3d(0.0, 0.5, -0.8).normalized();
  add_rectangle(points, {0.0, 0.1, 1.0}, {1.0, 0.0, 0.0},
                0.8 * tilted.cross(Eigen::Vector3d::UnitX()), 0.003, random);
  const SceneOctree octree(points, kLeaf);
  const std::vector<SupportPlane> planes = find_support_planes(octree, options(), 7);
  ASSERT_EQ(planes.size(), 1u);
  const Eigen::Vector3d normal = tilted.dot(Eigen::Vector3d(0.0, 0.1, 1.0)) > 0 ? -tilted : tilted;
  EXPECT_LT(std::acos(planes[0].normal.dot(normal)), 0.005);
  EXPECT_NEAR(planes[0].height({0.0, 0.1, 1.0}), 0.0, 0.0005);
  EXPECT_LT(planes[0].tolerance, 0.01);
}

TEST(SupportPlane, CoplanarBoxTopsAreNoTable) {
  // Two large tops side by side, larger together than the least area; the table below is seen
  // between and around them.
  Random random(2);
  std::vector<Eigen::Vector3f> points;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  add_rectangle(points, {-0.16, 0.0, 0.9}, 0.22 * x, 0.3 * y, 0.003, random);
  add_rectangle(points, {0.16, 0.0, 0.9}, 0.22 * x, 0.3 * y, 0.003, random);
  add_rectangle(points, {0.0, 0.0, 0.98}, 0.08 * x, 0.4 * y, 0.003, random);
  const SceneOctree octree(points, kLeaf);
  for (const SupportPlane& plane : find_support_planes(octree, options(), 7)) {
    EXPECT_LT(plane.height({0.16, 0.0, 0.9}), 1.0);
    EXPECT_GT(plane.height({0.16, 0.0, 0.9}), plane.tolerance) << "a box top was taken for support";
  }
}

TEST(SupportPlane, StrayPointsBesideATableDoNotMakeTheFloorBehindIt) {
  // Beyond the table's far edge one sees the floor; a few blurred points there lie in the table's
  // plane by chance.
  Random random(6);
  std::vector<Eigen::Vector3f> points;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  add_rectangle(points, {0.0, 0.1, 0.9}, 0.8 * x, 0.4 * y, 0.003, random);
  add_rectangle(points, {0.0, -0.45, 1.6}, 1.4 * x, 0.5 * y, 0.005, random);
  for (int i = 0; i < 60; ++i) {
    points.push_back(
        Eigen::Vector3d(random.uniform(-0.4, 0.4), random.uniform(-0.3, -0.1), 0.9).cast<float>());
  }
  const auto planes = find_support_planes(SceneOctree(points, kLeaf), options(), 7);
  ASSERT_FALSE(planes.empty());
  const bool has_table = std::any_of(planes.begin(), planes.end(), [](const SupportPlane& plane) {
    return std::abs(plane.height({0.0, 0.1, 0.9})) < plane.tolerance;
  });
  EXPECT_TRUE(has_table);
}

TEST(SupportPlane, ASmallFaceIsNoSupport) {
  Random random(3);
  std::vector<Eigen::Vector3f> points;
  add_rectangle(points, {0.0, 0.0, 0.9}, {0.16, 0.0, 0.0}, {0.0, 0.16, 0.0}, 0.003, random);
  EXPECT_TRUE(find_support_planes(SceneOctree(points, kLeaf), options(), 7).empty());
}

TEST(SupportPlane, FollowsTheBowOfTheSensor) {
  Random random(4);
  std::vector<Eigen::Vector3f> points;
  for (double x = -0.5; x < 0.5; x += 0.003) {
    for (double y = -0.4; y < 0.4; y += 0.003) {
      points.push_back(
          Eigen::Vector3d(x, y, 1.0 + 0.01 * x * x + 0.0005 * random.normal()).cast<float>());
    }
  }
  const auto planes = find_support_planes(SceneOctree(points, kLeaf), options(), 7);
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_NEAR(planes[0].height({0.45, 0.0, 1.0 + 0.01 * 0.45 * 0.45}), 0.0, 0.0007);
  EXPECT_NEAR(planes[0].height({0.0, 0.0, 1.0}), 0.0, 0.0007);
  EXPECT_NEAR(planes[0].height({0.45, 0.0, 0.95}), 0.05, 0.003);  // towards the sensor is up
}

TEST(SupportPlane, PilesStandOnTheTableAndStay) {
  const testing::SceneGenerator generator(testing::known_objects());
  for (Seed seed = 1; seed <= 4; ++seed) {
    const auto scene = generator.make(testing::SceneKind::kPile, seed);
    const RangeImage image = testing::add_kinect_noise(scene.clean, {}, seed);
    const ObservedScene observed(image, {0.005, 0.054}, 1, seed);
    ASSERT_FALSE(observed.support_planes().empty());
    for (const testing::TrueInstance& instance : scene.instances) {
      const SupportPlane& table = observed.support_planes().front();
      EXPECT_GT(table.height(instance.T_camera_model.translation()), 0.02);
    }
    EXPECT_GT(observed.object_leaves().size(), 2000u);
    EXPECT_LT(observed.object_leaves().size(), 0.4 * observed.octree().size());
  }
}

}  // namespace
}  // namespace binpick
