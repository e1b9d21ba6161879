#pragma once

#include <Eigen/Core>
#include <vector>

#include "recognition/scene_octree.h"

namespace binpick {

/// Finds L, the points in a shell about one of them (IJRR 2012, Algorithm 1, line 6). The points
/// lie sorted in coarse cells as wide as the shell's outer radius, so that a query looks at those
/// near by only, whatever the scene's size, and costs little where few are left.
/// Immutable, thread-safe.
class ShellSampler {
 public:
  /// The shell of all points no closer than radius - tolerance and no farther than radius +
  /// tolerance, among `leaves` of `octree`. Of very many leaves it takes an even part: p_v is as
  /// random among those.
  ShellSampler(const SceneOctree& octree, const std::vector<int>& leaves, float radius,
               float tolerance);

  /// Writes L about `centre` to `shell`, as leaves. The order is fixed.
  void collect(const Eigen::Vector3f& centre, std::vector<int>& shell) const;

 private:
  struct Point {
    Eigen::Vector3f p;
    int leaf;
  };

  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3f& p) const;
  [[nodiscard]] std::size_t index_of(int x, int y, int z) const {
    const int index = (z * cells_.y() + y) * cells_.x() + x;
    return static_cast<std::size_t>(index);
  }

  float squared_inner_;
  float squared_outer_;
  float inverse_cell_ = 0.0f;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
  Eigen::Vector3i cells_ = Eigen::Vector3i::Zero();
  std::vector<Point> points_;  // by cell
  std::vector<int> first_;     // of each cell in points_, and the end
};

}  // namespace binpick
