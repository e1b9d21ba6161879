#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
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
/// by hashing, one bit per leaf. A query meets the same leaves as in a binary octree, each in
/// constant time. Leaves of one brick are consecutive. Immutable, thread-safe.
class SceneOctree {
 public:
  /// Writes the points [begin, end) to `points`.
  using PointSource =
      std::function<void(std::size_t begin, std::size_t end, Eigen::Vector3f* points)>;

  /// Points that are not finite or farther than 2^20 leaves from the origin are ignored. O(count),
  /// on up to `jobs` threads, which call `source`; the result is the same for any number.
  SceneOctree(std::size_t count, const PointSource& source, float leaf_size, int jobs);
  SceneOctree(const std::vector<Eigen::Vector3f>& points, float leaf_size, int jobs = 1);

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

  /// The plane through all input points in `leaf` and its neighbours.
  [[nodiscard]] LocalPlane plane_at(int leaf) const;

 private:
  /// Moments of the points of a leaf about the centre of its cell.
  struct Moments {
    float count = 0.0f;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    std::array<float, 6> squares = {};  // xx, xy, xz, yy, yz, zz

    void add(const Eigen::Vector3f& d);
    void add(const Moments& other);
  };

  /// Which of 8 x 8 x 8 leaves are full.
  struct Brick {
    Eigen::Vector3i coordinates;
    int first_leaf = 0;
    std::array<std::uint64_t, 8> full = {};    // by z; bits by y, x
    std::array<std::uint16_t, 8> before = {};  // full leaves of lower z

    [[nodiscard]] int leaf(const Eigen::Vector3i& cell) const {
      const auto layer = static_cast<std::size_t>(cell.z() & 7);
      const int bit = ((cell.y() & 7) << 3) | (cell.x() & 7);
      if ((full[layer] >> bit & 1u) == 0) return -1;
      const std::uint64_t earlier = full[layer] & ((std::uint64_t{1} << bit) - 1);
      return first_leaf + before[layer] + std::popcount(earlier);
    }
  };

  /// Bricks by open addressing over their coordinates.
  class BrickTable {
   public:
    [[nodiscard]] int find(const std::vector<Brick>& bricks,
                           const Eigen::Vector3i& coordinates) const;
    int find_or_add(std::vector<Brick>& bricks, const Eigen::Vector3i& coordinates);
    void rebuild(const std::vector<Brick>& bricks);

   private:
    std::vector<std::int32_t> slots_ = std::vector<std::int32_t>(256, -1);
  };

  struct Chunk;
  struct Partition;

  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3f& p) const;
  [[nodiscard]] Chunk gather(const std::vector<Eigen::Vector3f>& points) const;
  void fill(const std::vector<Chunk>& chunks, const Partition& partition, int first_brick,
            int first_leaf);
  [[nodiscard]] int find_brick(const Eigen::Vector3i& coordinates) const {
    return table_.find(bricks_, coordinates);
  }

  template <class Visit>
  void for_each_neighbour(int leaf, const Visit& visit) const;

  float leaf_size_;
  float inverse_leaf_size_;
  std::vector<Brick> bricks_;
  BrickTable table_;
  std::vector<Eigen::Vector3i> cells_;
  std::vector<Moments> moments_;
  std::vector<Eigen::Vector3f> centres_of_mass_;
};

}  // namespace binpick
