#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace binpick {

/// The plane through the neighbourhood of a point of S*, by PCA (IJRR 2012, section 4.2, step 4).
struct LocalPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  ///< sign undefined
  float deviation = 0.0f;  ///< root mean square distance of the points from the plane, m
  float width = 0.0f;      ///< standard deviation along the second principal axis, m
  int points = 0;          ///< input points in the neighbourhood
};

/// The scene in leaves of equal size and its down-sampled version S*, the centres of mass of the
/// full leaves (IJRR 2012, section 4.2, step 1). Two leaves are neighbours if their integer
/// coordinates differ by no more than 1.
///
/// The tree has two levels instead of log2(extent / leaf) ones: bricks of 8 x 8 x 8 leaves, found
/// by hashing. A query meets the same leaves as in a binary octree, at a constant cost per brick.
/// Leaves of one brick are consecutive. Immutable, thread-safe.
class SceneOctree {
 public:
  /// O(points). Points that are not finite or farther than 2^20 leaves from the origin are ignored.
  SceneOctree(const std::vector<Eigen::Vector3f>& points, float leaf_size);

  [[nodiscard]] int size() const noexcept { return static_cast<int>(centres_of_mass_.size()); }
  [[nodiscard]] float leaf_size() const noexcept { return leaf_size_; }

  /// S*, by leaf.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& points() const noexcept {
    return centres_of_mass_;
  }
  [[nodiscard]] const Eigen::Vector3f& point(int leaf) const {
    return centres_of_mass_[static_cast<std::size_t>(leaf)];
  }

  /// The full leaf that contains `p`, or -1. Constant time.
  [[nodiscard]] int leaf_at(const Eigen::Vector3f& p) const;

  /// The full leaves next to `leaf`, itself included.
  [[nodiscard]] std::vector<int> neighbours(int leaf) const;

  /// Replaces `leaves` by those whose point is no closer to `centre` than radius - tolerance and no
  /// farther than radius + tolerance: L of Algorithm 1, line 6. O(bricks that meet the shell).
  void shell(const Eigen::Vector3f& centre, float radius, float tolerance,
             std::vector<int>& leaves) const;

  /// The plane through all input points in `leaf` and its neighbours.
  [[nodiscard]] LocalPlane plane_at(int leaf) const;

 private:
  static constexpr int kBrickSide = 8;
  static constexpr int kBrickCells = kBrickSide * kBrickSide * kBrickSide;

  /// Moments of the points of a leaf about the centre of its cell.
  struct Moments {
    float count = 0.0f;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  };
  struct Brick {
    Eigen::Vector3i coordinates;
    int first_leaf = 0;
    int end_leaf = 0;
    std::array<std::int32_t, kBrickCells> leaves;
  };

  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3f& p) const;
  [[nodiscard]] int find_brick(const Eigen::Vector3i& coordinates) const;
  int find_or_add_brick(const Eigen::Vector3i& coordinates);
  void insert_slot(const Eigen::Vector3i& coordinates, int brick);
  [[nodiscard]] int leaf_at_cell(const Eigen::Vector3i& cell) const;
  void number_leaves_by_brick();

  template <class Visit>
  void for_each_neighbour(int leaf, const Visit& visit) const;

  float leaf_size_;
  std::vector<Brick> bricks_;
  std::vector<std::int32_t> slots_;  // open addressing over brick coordinates, -1 when free
  std::vector<Eigen::Vector3i> cells_;
  std::vector<Moments> moments_;
  std::vector<Eigen::Vector3f> centres_of_mass_;
};

}  // namespace binpick
