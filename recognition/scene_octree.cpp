#include "recognition/scene_octree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr float kFarthestCell = 1048576.0f;  // 2^20

std::size_t hash_of(const Eigen::Vector3i& coordinates) {
  const auto mix = [](int value, std::uint64_t factor) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value)) * factor;
  };
  std::uint64_t hash = mix(coordinates.x(), 0x9E3779B97F4A7C15u) ^
                       mix(coordinates.y(), 0xC2B2AE3D27D4EB4Fu) ^
                       mix(coordinates.z(), 0x165667B19E3779F9u);
  hash ^= hash >> 29;
  return static_cast<std::size_t>(hash * 0xBF58476D1CE4E5B9u >> 20);
}

int floor_to_brick(int cell) { return cell >> 3; }

std::size_t place_in_brick(const Eigen::Vector3i& cell) {
  return static_cast<std::size_t>(((cell.z() & 7) << 6) | ((cell.y() & 7) << 3) | (cell.x() & 7));
}

}  // namespace

SceneOctree::SceneOctree(const std::vector<Eigen::Vector3f>& points, float leaf_size)
    : leaf_size_(leaf_size), slots_(1024, -1) {
  Eigen::Vector3i last_brick_coordinates = Eigen::Vector3i::Constant(1 << 30);
  int last_brick = -1;
  for (const Eigen::Vector3f& p : points) {
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() >= kFarthestCell * leaf_size_) continue;
    const Eigen::Vector3i cell = cell_of(p);
    const Eigen::Vector3i coordinates = cell.unaryExpr(&floor_to_brick);
    if (coordinates != last_brick_coordinates) {
      last_brick = find_or_add_brick(coordinates);
      last_brick_coordinates = coordinates;
    }
    std::int32_t& leaf = bricks_[static_cast<std::size_t>(last_brick)].leaves[place_in_brick(cell)];
    if (leaf < 0) {
      leaf = static_cast<std::int32_t>(cells_.size());
      cells_.push_back(cell);
      moments_.emplace_back();
    }
    Moments& moments = moments_[static_cast<std::size_t>(leaf)];
    const Eigen::Vector3f d =
        p - leaf_size_ * (cell.cast<float>() + Eigen::Vector3f::Constant(0.5f));
    moments.count += 1.0f;
    moments.sum += d;
    moments.squares += d * d.transpose();
  }
  number_leaves_by_brick();
  centres_of_mass_.reserve(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    centres_of_mass_.emplace_back(leaf_size_ *
                                      (cells_[i].cast<float>() + Eigen::Vector3f::Constant(0.5f)) +
                                  moments_[i].sum / moments_[i].count);
  }
}

Eigen::Vector3i SceneOctree::cell_of(const Eigen::Vector3f& p) const {
  return (p / leaf_size_).array().floor().cast<int>();
}

int SceneOctree::find_brick(const Eigen::Vector3i& coordinates) const {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash_of(coordinates) & mask;; slot = (slot + 1) & mask) {
    const std::int32_t brick = slots_[slot];
    if (brick < 0 || bricks_[static_cast<std::size_t>(brick)].coordinates == coordinates) {
      return brick;
    }
  }
}

void SceneOctree::insert_slot(const Eigen::Vector3i& coordinates, int brick) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash_of(coordinates) & mask;
  while (slots_[slot] >= 0) slot = (slot + 1) & mask;
  slots_[slot] = brick;
}

int SceneOctree::find_or_add_brick(const Eigen::Vector3i& coordinates) {
  const int found = find_brick(coordinates);
  if (found >= 0) return found;
  if (2 * (bricks_.size() + 1) > slots_.size()) {
    slots_.assign(2 * slots_.size(), -1);
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      insert_slot(bricks_[i].coordinates, static_cast<int>(i));
    }
  }
  const int added = static_cast<int>(bricks_.size());
  Brick& brick = bricks_.emplace_back();
  brick.coordinates = coordinates;
  brick.leaves.fill(-1);
  insert_slot(coordinates, added);
  return added;
}

void SceneOctree::number_leaves_by_brick() {
  std::vector<Eigen::Vector3i> cells;
  std::vector<Moments> moments;
  cells.reserve(cells_.size());
  moments.reserve(moments_.size());
  for (Brick& brick : bricks_) {
    brick.first_leaf = static_cast<int>(cells.size());
    for (std::int32_t& leaf : brick.leaves) {
      if (leaf < 0) continue;
      cells.push_back(cells_[static_cast<std::size_t>(leaf)]);
      moments.push_back(moments_[static_cast<std::size_t>(leaf)]);
      leaf = static_cast<std::int32_t>(cells.size()) - 1;
    }
    brick.end_leaf = static_cast<int>(cells.size());
  }
  cells_ = std::move(cells);
  moments_ = std::move(moments);
}

int SceneOctree::leaf_at_cell(const Eigen::Vector3i& cell) const {
  const int brick = find_brick(cell.unaryExpr(&floor_to_brick));
  return brick < 0 ? -1 : bricks_[static_cast<std::size_t>(brick)].leaves[place_in_brick(cell)];
}

int SceneOctree::leaf_at(const Eigen::Vector3f& p) const {
  if (!p.allFinite() || p.cwiseAbs().maxCoeff() >= kFarthestCell * leaf_size_) return -1;
  return leaf_at_cell(cell_of(p));
}

template <class Visit>
void SceneOctree::for_each_neighbour(int leaf, const Visit& visit) const {
  const Eigen::Vector3i cell = cells_[static_cast<std::size_t>(leaf)];
  const Eigen::Vector3i own = cell.unaryExpr(&floor_to_brick);
  const int own_brick = find_brick(own);
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector3i other = cell + Eigen::Vector3i(dx, dy, dz);
        const Eigen::Vector3i coordinates = other.unaryExpr(&floor_to_brick);
        const int brick = coordinates == own ? own_brick : find_brick(coordinates);
        if (brick < 0) continue;
        const int found = bricks_[static_cast<std::size_t>(brick)].leaves[place_in_brick(other)];
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

void SceneOctree::shell(const Eigen::Vector3f& centre, float radius, float tolerance,
                        std::vector<int>& leaves) const {
  leaves.clear();
  const float inner = std::max(radius - tolerance, 0.0f);
  const float outer = radius + tolerance;
  const float brick_size = leaf_size_ * kBrickSide;
  const Eigen::Vector3i low = ((centre.array() - outer) / brick_size).floor().cast<int>();
  const Eigen::Vector3i high = ((centre.array() + outer) / brick_size).floor().cast<int>();
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Eigen::Vector3f corner = brick_size * Eigen::Vector3f(float(x), float(y), float(z));
        const Eigen::Array3f below = corner.array() - centre.array();
        const Eigen::Array3f above = below + brick_size;
        const float nearest = below.max(-above).max(0.0f).matrix().squaredNorm();
        const float farthest = below.abs().max(above.abs()).matrix().squaredNorm();
        if (nearest > outer * outer || farthest < inner * inner) continue;
        const int index = find_brick({x, y, z});
        if (index < 0) continue;
        const Brick& brick = bricks_[static_cast<std::size_t>(index)];
        for (int leaf = brick.first_leaf; leaf < brick.end_leaf; ++leaf) {
          const float squared = (point(leaf) - centre).squaredNorm();
          if (squared >= inner * inner && squared <= outer * outer) leaves.push_back(leaf);
        }
      }
    }
  }
}

LocalPlane SceneOctree::plane_at(int leaf) const {
  float count = 0.0f;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  for_each_neighbour(leaf, [&](int other, const Eigen::Vector3i& step) {
    const Moments& moments = moments_[static_cast<std::size_t>(other)];
    const Eigen::Vector3f shift = leaf_size_ * step.cast<float>();
    count += moments.count;
    sum += moments.sum + moments.count * shift;
    squares += moments.squares + moments.sum * shift.transpose() + shift * moments.sum.transpose() +
               moments.count * shift * shift.transpose();
  });
  LocalPlane plane;
  plane.points = static_cast<int>(count);
  const Eigen::Vector3f mean = sum / count;
  const Eigen::Matrix3f covariance = squares / count - mean * mean.transpose();
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
