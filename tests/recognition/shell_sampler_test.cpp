#include "recognition/shell_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

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

TEST(ShellSampler, VisitsWhatBruteForceFindsOnce) {
  const SceneOctree octree = random_octree(3);
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const auto centre = static_cast<int>(random.index(static_cast<std::uint64_t>(octree.size())));
    const auto radius = static_cast<float>(random.uniform(0.0, 0.2));
    const auto tolerance = static_cast<float>(random.uniform(0.001, 0.01));
    std::set<int> expected;
    for (int leaf = 0; leaf < octree.size(); ++leaf) {
      const float distance = (octree.point(leaf) - octree.point(centre)).norm();
      if (distance >= radius - tolerance && distance <= radius + tolerance) expected.insert(leaf);
    }
    std::vector<int> found;
    ShellSampler(octree, radius, tolerance).visit_in_random_order(centre, random, [&](int leaf) {
      found.push_back(leaf);
      return false;
    });
    EXPECT_EQ(std::set<int>(found.begin(), found.end()).size(), found.size());
    // A point within rounding of the shell's edge may fall on either side.
    for (const int leaf : found) expected.insert(leaf);
    for (const int leaf : expected) {
      if (std::find(found.begin(), found.end(), leaf) != found.end()) continue;
      const float distance = (octree.point(leaf) - octree.point(centre)).norm();
      EXPECT_LT(std::min(std::abs(distance - radius - tolerance),
                         std::abs(distance - radius + tolerance)),
                1e-6f);
    }
  }
}

TEST(ShellSampler, DrawsAllPointsOfAShellAboutEquallyOften) {
  const SceneOctree octree = random_octree(5);
  const ShellSampler sampler(octree, 0.06f, 0.005f);
  const int centre = octree.size() / 2;
  Random random(6);
  std::map<int, int> drawn;
  constexpr int kDraws = 40000;
  for (int i = 0; i < kDraws; ++i) {
    sampler.visit_in_random_order(centre, random, [&](int leaf) {
      ++drawn[leaf];
      return true;
    });
  }
  std::size_t in_shell = 0;
  sampler.visit_in_random_order(centre, random, [&](int) {
    ++in_shell;
    return false;
  });
  ASSERT_GT(in_shell, 50u);
  // The gaps of a shuffled list are geometrically distributed: nearly all points are drawn, none
  // much more often than log(points) times its share.
  EXPECT_GT(static_cast<double>(drawn.size()), 0.75 * static_cast<double>(in_shell));
  for (const auto& [leaf, count] : drawn) {
    EXPECT_LT(count * static_cast<double>(in_shell), 12.0 * kDraws);
  }
}

TEST(ShellSampler, AnEmptyShellGivesNothing) {
  const SceneOctree octree({Eigen::Vector3f(0.0f, 0.0f, 1.0f)}, kLeaf);
  Random random(1);
  ShellSampler(octree, 0.06f, 0.005f).visit_in_random_order(0, random, [](int) {
    ADD_FAILURE() << "there is no other point";
    return true;
  });
}

}  // namespace
}  // namespace binpick
