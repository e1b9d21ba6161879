#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "models/random.h"
#include "recognition/scene_octree.h"

namespace binpick {

/// Draws from L, the points of S* in a shell about one of them (IJRR 2012, Algorithm 1, lines 6-7).
/// The offsets from a leaf to all leaves that the shell may meet are the same everywhere, so they
/// are listed once, shuffled; a draw takes the points of L in the order of that list from a random
/// place on. Immutable, thread-safe.
class ShellSampler {
 public:
  /// The shell of all points no closer than radius - tolerance and no farther than radius +
  /// tolerance, over the leaves of `octree`, which must outlive the sampler.
  ShellSampler(const SceneOctree& octree, float radius, float tolerance);

  /// Visits the leaves of L in random order until `visit(leaf)` returns true; each once. O(full
  /// leaves within the shell's reach).
  template <class Visit>
  void visit_in_random_order(int leaf, Random& random, const Visit& visit) const {
    if (offsets_ == 0) return;
    for (const Turn& turn : shuffled(leaf, static_cast<int>(random.index(offsets_)))) {
      if (visit(turn.leaf)) return;
    }
  }

 private:
  struct Turn {
    int place;  // in the list, counted from where the draw begins
    int leaf;
  };
  /// L in the order of the list from `start` on.
  [[nodiscard]] std::vector<Turn> shuffled(int leaf, int start) const;
  [[nodiscard]] std::size_t index_of(const Eigen::Vector3i& offset) const {
    const int side = 2 * reach_ + 1;
    return static_cast<std::size_t>(((offset.z() + reach_) * side + offset.y() + reach_) * side +
                                    offset.x() + reach_);
  }

  const SceneOctree& octree_;
  float squared_inner_;
  float squared_outer_;
  int reach_;                         // leaves
  std::size_t offsets_ = 0;           // in the list
  std::vector<int> place_of_offset_;  // in the list, by index_of; -1 for those that are not in it
};

}  // namespace binpick
