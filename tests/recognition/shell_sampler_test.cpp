#include "recognition/shell_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "models/random.h"

namespace binpick {
namespace {

constexpr float kLeaf = 0.01f;

SceneOctree random_octree(Seed seed) {
  Random random(seed);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 8000; ++i) {
    points.push_back(Eigen::Vector3d(random.uniform(-0.15, 0.15), random.uniform(-0.1, 0.1),
                                     random.uniform(0.7, 0.9))
                         .cast<float>());
  }
  return SceneOctree(points, kLeaf);
}

std::vector<int> every(int step, const SceneOctree& octree) {
  std::vector<int> leaves;
  for (int leaf = 0; leaf < octree.size(); leaf += step) leaves.push_back(leaf);
  return leaves;
}

TEST(ShellSampler, CollectsWhatBruteForceFindsOnce) {
  const SceneOctree octree = random_octree(3);
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const std::vector<int> leaves = every(1 + i % 5, octree);
    const Eigen::Vector3f centre = octree.point(leaves[random.index(leaves.size())]);
    const auto radius = static_cast<float>(random.uniform(0.0, 0.2));
    const auto tolerance = static_cast<float>(random.uniform(0.001, 0.01));
    std::vector<int> expected;
    for (const int leaf : leaves) {
      const float squared = (octree.point(leaf) - centre).squaredNorm();
      const float inner = std::max(radius - tolerance, 0.0f);
      const float outer = radius + tolerance;
      if (squared >= inner * inner && squared <= outer * outer) expected.push_back(leaf);
    }
    std::vector<int> found{-7};  // of an earlier query
    ShellSampler(octree, leaves, radius, tolerance).collect(centre, found);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(ShellSampler, ASceneMuchWiderThanTheShellTakesBoundedMemory) {
  std::vector<Eigen::Vector3f> points;
  for (const float far : {0.0f, 1e3f}) {
    for (const float near : {0.0f, 0.06f}) points.emplace_back(far + near, far, 1.0f + far);
  }
  const SceneOctree octree(points, kLeaf);
  ASSERT_EQ(octree.size(), 4);
  const ShellSampler sampler(octree, every(1, octree), 0.06f, 0.005f);
  for (int leaf = 0; leaf < octree.size(); ++leaf) {
    std::vector<int> shell;
    sampler.collect(octree.point(leaf), shell);
    EXPECT_EQ(shell.size(), 1u);
  }
}

/// 216 000 leaves that fill a cube, its corner at the origin.
std::vector<Eigen::Vector3f> full_cube() {
  std::vector<Eigen::Vector3f> points;
  for (int x = 0; x < 60; ++x) {
    for (int y = 0; y < 60; ++y) {
      for (int z = 0; z < 60; ++z) {
        points.emplace_back(
            kLeaf * (Eigen::Vector3i(x, y, z).cast<float>() + Eigen::Vector3f::Constant(0.5f)));
      }
    }
  }
  return points;
}

TEST(ShellSampler, LooksThroughAnEvenPartOfVeryManyPoints) {
  const SceneOctree octree(full_cube(), kLeaf);
  ASSERT_EQ(octree.size(), 216'000);
  const ShellSampler sampler(octree, every(1, octree), 0.1f, kLeaf);
  std::vector<int> shell;
  sampler.collect(Eigen::Vector3f::Constant(0.3f), shell);
  // 4 pi d^2 2 tolerance, in leaves.
  const double whole = 4.0 * M_PI * 100.0 * 2.0;
  EXPECT_GT(static_cast<double>(shell.size()), 0.15 * whole);
  EXPECT_LT(static_cast<double>(shell.size()), 0.25 * whole);
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const int leaf : shell) mean += octree.point(leaf) / static_cast<float>(shell.size());
  EXPECT_LT((mean - Eigen::Vector3f::Constant(0.3f)).norm(), 1.5f * kLeaf);
}

TEST(ShellSampler, APointFarFromThatPartHasAnEmptyShell) {
  std::vector<Eigen::Vector3f> points = full_cube();
  for (const float x : {-1e3f, 1e3f}) points.emplace_back(x, 0.001f, 0.001f);
  for (const float y : {-1e3f, 1e3f}) points.emplace_back(0.599f, y, 0.599f);
  const SceneOctree octree(points, kLeaf);
  std::vector<int> leaves = every(1, octree);
  const auto is_far = [&](int leaf) { return octree.point(leaf).norm() > 2.0f; };
  std::stable_partition(leaves.begin(), leaves.end(), is_far);
  ASSERT_TRUE(is_far(leaves[3]) && !is_far(leaves[4]));
  std::swap(leaves[0], leaves[4]);  // the first is taken, of those after it every fifth
  std::swap(leaves[4], leaves[6]);
  const ShellSampler sampler(octree, leaves, 0.1f, kLeaf);
  for (const int far : {leaves[1], leaves[2], leaves[3], leaves[6]}) {
    ASSERT_TRUE(is_far(far));
    std::vector<int> shell;
    sampler.collect(octree.point(far), shell);
    EXPECT_TRUE(shell.empty());
  }
}

TEST(ShellSampler, AnEmptyShellGivesNothing) {
  const SceneOctree octree({Eigen::Vector3f(0.0f, 0.0f, 1.0f)}, kLeaf);
  std::vector<int> shell{0};
  ShellSampler(octree, {0}, 0.06f, 0.005f).collect(octree.point(0), shell);
  EXPECT_TRUE(shell.empty());
  shell = {0};
  ShellSampler(octree, {}, 0.06f, 0.005f).collect(octree.point(0), shell);
  EXPECT_TRUE(shell.empty());
}

}  // namespace
}  // namespace binpick
