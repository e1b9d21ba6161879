#include "recognition/scene_octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "models/random.h"

namespace binpick {
namespace {

constexpr float kLeaf = 0.01f;

std::vector<Eigen::Vector3f> random_points(int count, Seed seed) {
  Random random(seed);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(Eigen::Vector3d(random.uniform(-0.15, 0.15), random.uniform(-0.1, 0.1),
                                     random.uniform(0.7, 0.9))
                         .cast<float>());
  }
  return points;
}

using Cell = std::array<int, 3>;

Cell cell_of(const Eigen::Vector3f& p) {
  return {static_cast<int>(std::floor(p.x() / kLeaf)), static_cast<int>(std::floor(p.y() / kLeaf)),
          static_cast<int>(std::floor(p.z() / kLeaf))};
}

TEST(SceneOctree, PointsAreTheCentresOfMassOfFullLeaves) {
  const std::vector<Eigen::Vector3f> points = random_points(5000, 1);
  std::map<Cell, std::pair<Eigen::Vector3d, int>> leaves;
  for (const Eigen::Vector3f& p : points) {
    auto& [sum, count] = leaves.try_emplace(cell_of(p), Eigen::Vector3d::Zero(), 0).first->second;
    sum += p.cast<double>();
    ++count;
  }
  const SceneOctree octree(points, kLeaf);
  ASSERT_EQ(octree.size(), static_cast<int>(leaves.size()));
  for (const auto& [cell, sum_and_count] : leaves) {
    const Eigen::Vector3f mean = (sum_and_count.first / sum_and_count.second).cast<float>();
    const int leaf = octree.leaf_at(mean);
    ASSERT_GE(leaf, 0);
    EXPECT_LT((octree.point(leaf) - mean).norm(), 1e-5f);
  }
}

TEST(SceneOctree, NeighboursDifferByAtMostOneInEveryCoordinate) {
  const SceneOctree octree(random_points(3000, 2), kLeaf);
  for (int leaf = 0; leaf < octree.size(); leaf += 37) {
    const Cell own = cell_of(octree.point(leaf));
    std::set<int> expected;
    for (int other = 0; other < octree.size(); ++other) {
      const Cell cell = cell_of(octree.point(other));
      const int farthest = std::max(
          {std::abs(cell[0] - own[0]), std::abs(cell[1] - own[1]), std::abs(cell[2] - own[2])});
      if (farthest <= 1) expected.insert(other);
    }
    const std::vector<int> found = octree.neighbours(leaf);
    EXPECT_EQ(std::set<int>(found.begin(), found.end()), expected);
    EXPECT_EQ(found.size(), expected.size());
  }
}

TEST(SceneOctree, DoesNotDependOnTheNumberOfThreads) {
  const std::vector<Eigen::Vector3f> points = random_points(60000, 6);
  const SceneOctree one(points, kLeaf, 1);
  for (const int jobs : {2, 5}) {
    const SceneOctree many(points, kLeaf, jobs);
    ASSERT_EQ(many.points(), one.points());
    for (int leaf = 0; leaf < one.size(); leaf += 97) {
      EXPECT_EQ(many.plane_at(leaf).normal, one.plane_at(leaf).normal);
    }
  }
}

TEST(SceneOctree, PlaneFitFindsNormalAndNoise) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.4, -0.9).normalized();
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  constexpr double kNoise = 0.0005;
  Random random(5);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 60000; ++i) {
    points.push_back((Eigen::Vector3d(0.0, 0.0, 0.8) + random.uniform(-0.1, 0.1) * u +
                      random.uniform(-0.1, 0.1) * v + kNoise * random.normal() * normal)
                         .cast<float>());
  }
  const SceneOctree octree(points, kLeaf);
  const LocalPlane plane = octree.plane_at(octree.leaf_at({0.0f, 0.0f, 0.8f}));
  EXPECT_GT(std::abs(plane.normal.dot(normal.cast<float>())), 0.999f);
  EXPECT_NEAR(plane.deviation, kNoise, 0.3 * kNoise);
  EXPECT_GT(plane.points, 500);
}

TEST(SceneOctree, IgnoresWhatIsNoPoint) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const SceneOctree octree({{nan, 0.0f, 1.0f}, {infinity, 0.0f, 0.0f}, {1e30f, 0.0f, 0.0f}}, kLeaf);
  EXPECT_EQ(octree.size(), 0);
  EXPECT_EQ(octree.leaf_at({nan, 0.0f, 0.0f}), -1);
}

}  // namespace
}  // namespace binpick
