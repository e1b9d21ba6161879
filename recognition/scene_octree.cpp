#include "recognition/scene_octree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "recognition/parallel_for.h"

namespace binpick {
namespace {

constexpr float kFarthestCell = 1048576.0f;  // 2^20
constexpr std::size_t kChunkPoints = 8192;
constexpr int kPartitions = 16;

std::uint64_t hash_of(const Eigen::Vector3i& coordinates) {
  const auto mix = [](int value, std::uint64_t factor) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value)) * factor;
  };
  std::uint64_t hash = mix(coordinates.x(), 0x9E3779B97F4A7C15u) ^
                       mix(coordinates.y(), 0xC2B2AE3D27D4EB4Fu) ^
                       mix(coordinates.z(), 0x165667B19E3779F9u);
  hash ^= hash >> 29;
  return hash * 0xBF58476D1CE4E5B9u >> 20;
}

int round_down(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

Eigen::Vector3i brick_of(const Eigen::Vector3i& cell) {
  return {cell.x() >> 3, cell.y() >> 3, cell.z() >> 3};
}

Eigen::Vector3f centre_of(const Eigen::Vector3i& cell, float leaf_size) {
  return leaf_size * (cell.cast<float>() + Eigen::Vector3f::Constant(0.5f));
}

}  // namespace

/// Leaves as one chunk of the input fills them, in order of appearance; a leaf may appear again.
struct SceneOctree::Chunk {
  std::vector<Eigen::Vector3i> cells;
  std::vector<Moments> moments;
  std::vector<std::uint8_t> partitions;  // that the leaf's brick belongs to
  std::vector<std::int32_t> by_partition;
  std::array<std::size_t, kPartitions + 1> first = {};  // of each partition in by_partition

  void sort_by_partition();
};

/// A part of the bricks, chosen by hash: built by one thread from the chunks in their order.
struct SceneOctree::Partition {
  Partition() = default;
  Partition(const std::vector<Chunk>& chunks, std::size_t index);

  /// Calls visit(chunk, i) for the chunks' leaves in this partition, always in the same order.
  template <class Visit>
  void for_each_leaf(const std::vector<Chunk>& chunks, const Visit& visit) const {
    for (const Chunk& chunk : chunks) {
      for (std::size_t k = chunk.first[index]; k < chunk.first[index + 1]; ++k) {
        visit(chunk, static_cast<std::size_t>(chunk.by_partition[k]));
      }
    }
  }

  std::size_t index = 0;
  std::vector<Brick> bricks;
  std::vector<std::int32_t> brick_of_leaf;  // in the order of for_each_leaf
  int leaves = 0;
};

void SceneOctree::Chunk::sort_by_partition() {
  for (const std::uint8_t partition : partitions) ++first[partition + 1u];
  std::partial_sum(first.begin(), first.end(), first.begin());
  auto next = first;
  by_partition.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    by_partition[next[partitions[i]]++] = static_cast<std::int32_t>(i);
  }
}

void SceneOctree::Moments::add(const Eigen::Vector3f& d) {
  count += 1.0f;
  sum += d;
  squares[0] += d.x() * d.x();
  squares[1] += d.x() * d.y();
  squares[2] += d.x() * d.z();
  squares[3] += d.y() * d.y();
  squares[4] += d.y() * d.z();
  squares[5] += d.z() * d.z();
}

void SceneOctree::Moments::add(const Moments& other) {
  count += other.count;
  sum += other.sum;
  for (std::size_t i = 0; i < squares.size(); ++i) squares[i] += other.squares[i];
}

int SceneOctree::BrickTable::find(const std::vector<Brick>& bricks,
                                  const Eigen::Vector3i& coordinates) const {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash_of(coordinates) & mask;; slot = (slot + 1) & mask) {
    const std::int32_t brick = slots_[slot];
    if (brick < 0 || bricks[static_cast<std::size_t>(brick)].coordinates == coordinates) {
      return brick;
    }
  }
}

int SceneOctree::BrickTable::find_or_add(std::vector<Brick>& bricks,
                                         const Eigen::Vector3i& coordinates) {
  const int found = find(bricks, coordinates);
  if (found >= 0) return found;
  bricks.emplace_back().coordinates = coordinates;
  if (2 * bricks.size() > slots_.size()) {
    rebuild(bricks);
  } else {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash_of(coordinates) & mask;
    while (slots_[slot] >= 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<std::int32_t>(bricks.size()) - 1;
  }
  return static_cast<int>(bricks.size()) - 1;
}

void SceneOctree::BrickTable::rebuild(const std::vector<Brick>& bricks) {
  slots_.assign(std::bit_ceil(4 * bricks.size() + 1), -1);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    std::size_t slot = hash_of(bricks[i].coordinates) & mask;
    while (slots_[slot] >= 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<std::int32_t>(i);
  }
}

SceneOctree::Partition::Partition(const std::vector<Chunk>& chunks, std::size_t part)
    : index(part) {
  BrickTable table;
  int current = -1;  // often that of the leaf before
  for_each_leaf(chunks, [&](const Chunk& chunk, std::size_t i) {
    const Eigen::Vector3i& cell = chunk.cells[i];
    const Eigen::Vector3i coordinates = brick_of(cell);
    if (current < 0 || bricks[static_cast<std::size_t>(current)].coordinates != coordinates) {
      current = table.find_or_add(bricks, coordinates);
    }
    brick_of_leaf.push_back(current);
    bricks[static_cast<std::size_t>(current)].full[static_cast<std::size_t>(cell.z() & 7)] |=
        std::uint64_t{1} << (((cell.y() & 7) << 3) | (cell.x() & 7));
  });
  for (Brick& brick : bricks) {
    brick.first_leaf = leaves;
    int within = 0;
    for (std::size_t z = 0; z < brick.full.size(); ++z) {
      brick.before[z] = static_cast<std::uint16_t>(within);
      within += std::popcount(brick.full[z]);
    }
    leaves += within;
  }
}

SceneOctree::SceneOctree(const std::vector<Eigen::Vector3f>& points, float leaf_size, int jobs)
    : SceneOctree(
          points.size(),
          [&](std::size_t begin, std::size_t end, Eigen::Vector3f* out) {
            std::copy(points.data() + begin, points.data() + end, out);
          },
          leaf_size, jobs) {}

SceneOctree::SceneOctree(std::size_t count, const PointSource& source, float leaf_size, int jobs)
    : leaf_size_(leaf_size), inverse_leaf_size_(1.0f / leaf_size) {
  std::vector<Chunk> chunks((count + kChunkPoints - 1) / kChunkPoints);
  parallel_for(static_cast<int>(chunks.size()), jobs, [&](int i) {
    const std::size_t begin = static_cast<std::size_t>(i) * kChunkPoints;
    std::vector<Eigen::Vector3f> points(std::min(kChunkPoints, count - begin));
    source(begin, begin + points.size(), points.data());
    chunks[static_cast<std::size_t>(i)] = gather(points);
  });
  std::vector<Partition> partitions(kPartitions);
  parallel_for(kPartitions, jobs, [&](int i) {
    partitions[static_cast<std::size_t>(i)] = Partition(chunks, static_cast<std::size_t>(i));
  });
  std::vector<int> first_brick = {0};
  std::vector<int> first_leaf = {0};
  for (const Partition& partition : partitions) {
    first_brick.push_back(first_brick.back() + static_cast<int>(partition.bricks.size()));
    first_leaf.push_back(first_leaf.back() + partition.leaves);
  }
  bricks_.resize(static_cast<std::size_t>(first_brick.back()));
  cells_.resize(static_cast<std::size_t>(first_leaf.back()));
  moments_.resize(cells_.size());
  centres_of_mass_.resize(cells_.size());
  parallel_for(kPartitions, jobs, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    fill(chunks, partitions[index], first_brick[index], first_leaf[index]);
  });
  table_.rebuild(bricks_);
}

SceneOctree::Chunk SceneOctree::gather(const std::vector<Eigen::Vector3f>& points) const {
  // Most points fall into a leaf that was met a moment ago: a small cache finds it.
  constexpr std::size_t kCached = 2048;
  std::array<std::int32_t, kCached> cache;
  cache.fill(-1);
  Chunk chunk;
  chunk.cells.reserve(kCached);
  chunk.moments.reserve(kCached);
  chunk.partitions.reserve(kCached);
  const float farthest = kFarthestCell * leaf_size_;
  for (const Eigen::Vector3f& p : points) {
    // Written so that what is not a number fails.
    if (!(std::abs(p.x()) < farthest && std::abs(p.y()) < farthest && std::abs(p.z()) < farthest)) {
      continue;
    }
    const Eigen::Vector3i cell = cell_of(p);
    std::int32_t& cached =
        cache[static_cast<std::size_t>(cell.x() + 37 * cell.y() + 1013 * cell.z()) % kCached];
    if (cached < 0 || chunk.cells[static_cast<std::size_t>(cached)] != cell) {
      cached = static_cast<std::int32_t>(chunk.cells.size());
      chunk.cells.push_back(cell);
      chunk.moments.emplace_back();
      chunk.partitions.push_back(
          static_cast<std::uint8_t>((hash_of(brick_of(cell)) >> 32) % kPartitions));
    }
    chunk.moments[static_cast<std::size_t>(cached)].add(p - centre_of(cell, leaf_size_));
  }
  chunk.sort_by_partition();
  return chunk;
}

void SceneOctree::fill(const std::vector<Chunk>& chunks, const Partition& partition,
                       int first_brick, int first_leaf) {
  const auto bricks = bricks_.begin() + first_brick;
  for (std::size_t i = 0; i < partition.bricks.size(); ++i) {
    bricks[static_cast<std::ptrdiff_t>(i)] = partition.bricks[i];
    bricks[static_cast<std::ptrdiff_t>(i)].first_leaf += first_leaf;
  }
  auto brick = partition.brick_of_leaf.begin();
  partition.for_each_leaf(chunks, [&](const Chunk& chunk, std::size_t i) {
    const auto leaf = static_cast<std::size_t>(bricks[*brick++].leaf(chunk.cells[i]));
    cells_[leaf] = chunk.cells[i];
    moments_[leaf].add(chunk.moments[i]);
  });
  const auto end = static_cast<std::size_t>(first_leaf + partition.leaves);
  for (auto leaf = static_cast<std::size_t>(first_leaf); leaf < end; ++leaf) {
    centres_of_mass_[leaf] =
        centre_of(cells_[leaf], leaf_size_) + moments_[leaf].sum / moments_[leaf].count;
  }
}

Eigen::Vector3i SceneOctree::cell_of(const Eigen::Vector3f& p) const {
  return {round_down(p.x() * inverse_leaf_size_), round_down(p.y() * inverse_leaf_size_),
          round_down(p.z() * inverse_leaf_size_)};
}

int SceneOctree::leaf_at(const Eigen::Vector3f& p) const {
  if (!p.allFinite() || p.cwiseAbs().maxCoeff() >= kFarthestCell * leaf_size_) return -1;
  const Eigen::Vector3i cell = cell_of(p);
  const int brick = find_brick({cell.x() >> 3, cell.y() >> 3, cell.z() >> 3});
  return brick < 0 ? -1 : bricks_[static_cast<std::size_t>(brick)].leaf(cell);
}

template <class Visit>
void SceneOctree::for_each_neighbour(int leaf, const Visit& visit) const {
  const Eigen::Vector3i cell = cells_[static_cast<std::size_t>(leaf)];
  // The neighbourhood touches two bricks per axis at most.
  const Eigen::Vector3i low = brick_of(cell - Eigen::Vector3i::Ones());
  const Eigen::Vector3i high = brick_of(cell + Eigen::Vector3i::Ones());
  std::array<int, 8> bricks;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3i side(i & 1, i >> 1 & 1, i >> 2);
    const bool same_as_lower = ((side.array() == 1) && (low.array() == high.array())).any();
    bricks[static_cast<std::size_t>(i)] = same_as_lower ? -1 : find_brick(low + side);
  }
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector3i other = cell + Eigen::Vector3i(dx, dy, dz);
        const Eigen::Vector3i side = brick_of(other) - low;
        const int brick =
            bricks[static_cast<std::size_t>(side.x() | side.y() << 1 | side.z() << 2)];
        if (brick < 0) continue;
        const int found = bricks_[static_cast<std::size_t>(brick)].leaf(other);
        if (found >= 0) visit(found, Eigen::Vector3i(dx, dy, dz));
      }
    }
  }
}

std::vector<int> SceneOctree::neighbours(int leaf) const {
  std::vector<int> found;
  for_each_neighbour(leaf, [&](int other, const Eigen::Vector3i&) { found.push_back(other); });
  return found;
}

LocalPlane SceneOctree::plane_at(int leaf) const {
  float count = 0.0f;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  for_each_neighbour(leaf, [&](int other, const Eigen::Vector3i& step) {
    const Moments& m = moments_[static_cast<std::size_t>(other)];
    const Eigen::Vector3f shift = leaf_size_ * step.cast<float>();
    const Eigen::Vector3f moved = m.sum + m.count * shift;
    count += m.count;
    sum += moved;
    // About the centre of `leaf`: squares + sum shift' + shift sum' + count shift shift'.
    squares(0, 0) += m.squares[0] + (m.sum.x() + moved.x()) * shift.x();
    squares(0, 1) += m.squares[1] + m.sum.x() * shift.y() + shift.x() * moved.y();
    squares(0, 2) += m.squares[2] + m.sum.x() * shift.z() + shift.x() * moved.z();
    squares(1, 1) += m.squares[3] + (m.sum.y() + moved.y()) * shift.y();
    squares(1, 2) += m.squares[4] + m.sum.y() * shift.z() + shift.y() * moved.z();
    squares(2, 2) += m.squares[5] + (m.sum.z() + moved.z()) * shift.z();
  });
  LocalPlane plane;
  plane.points = static_cast<int>(count);
  const Eigen::Vector3f mean = sum / count;
  Eigen::Matrix3f covariance =
      (squares.selfadjointView<Eigen::Upper>().toDenseMatrix() / count) - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance.cast<double>() / (leaf_size_ * leaf_size_));
  plane.normal = solver.eigenvectors().col(0).normalized().cast<float>();
  const auto deviation = [&](int axis) {
    return leaf_size_ * static_cast<float>(std::sqrt(std::max(solver.eigenvalues()[axis], 0.0)));
  };
  plane.deviation = deviation(0);
  plane.width = deviation(1);
  return plane;
}

}  // namespace binpick
