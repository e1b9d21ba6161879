#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "models/random.h"
#include "recognition/scene_octree.h"

namespace binpick {

/// Draws from L, the points of S* in a shell about one of them (IJRR 2012, Algorithm 1, lines 6-7),
/// without collecting L: the offsets from a leaf to all leaves that the shell may meet are the same
/// everywhere, so they are listed once, shuffled; a draw walks the list from a random start to the
/// first full leaf whose point lies in the shell. Immutable, thread-safe.
class ShellSampler {
 public:
  /// The shell of all points no closer than radius - tolerance and no farther than radius +
  /// tolerance, over the leaves of `octree`, which must outlive the sampler.
  ShellSampler(const SceneOctree& octree, float radius, float tolerance);

  /// Visits the leaves of L in random order until `visit(leaf)` returns true; each once. O(offsets)
  /// at most, some dozens of them usually.
  template <class Visit>
  void visit_in_random_order(int leaf, Random& random, const Visit& visit) const {
    if (offsets_.empty()) return;
    const Eigen::Vector3i cell = octree_.cell(leaf);
    const Eigen::Vector3f centre = octree_.point(leaf);
    std::size_t i = random.index(offsets_.size());
    for (std::size_t step = 0; step < offsets_.size(); ++step) {
      const auto& [x, y, z] = offsets_[i];
      if (++i == offsets_.size()) i = 0;
      const int other = octree_.leaf_at_cell(cell + Eigen::Vector3i(x, y, z));
      if (other < 0) continue;
      const float squared = (octree_.point(other) - centre).squaredNorm();
      if (squared < squared_inner_ || squared > squared_outer_) continue;
      if (visit(other)) return;
    }
  }

 private:
  const SceneOctree& octree_;
  float squared_inner_;
  float squared_outer_;
  std::vector<std::array<std::int16_t, 3>> offsets_;
};

}  // namespace binpick
