#include "recognition/shell_sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace binpick {
namespace {

constexpr float kMostCells = 64.0f;          // per axis: bounds the memory of wide scenes
constexpr std::size_t kMostPoints = 50'000;  // bounds the cost of a query

/// At most kMostPoints of `leaves`, evenly over their order.
std::vector<int> even_part(const std::vector<int>& leaves) {
  const std::size_t stride = leaves.size() / kMostPoints + 1;
  std::vector<int> part;
  part.reserve(leaves.size() / stride + 1);
  for (std::size_t i = 0; i < leaves.size(); i += stride) part.push_back(leaves[i]);
  return part;
}

}  // namespace

ShellSampler::ShellSampler(const SceneOctree& octree, const std::vector<int>& leaves, float radius,
                           float tolerance) {
  const float inner = std::max(radius - tolerance, 0.0f);
  const float outer = radius + tolerance;
  squared_inner_ = inner * inner;
  squared_outer_ = outer * outer;
  if (leaves.empty()) return;
  const std::vector<int> kept = even_part(leaves);
  Eigen::AlignedBox3f box;
  for (const int leaf : leaves) box.extend(octree.point(leaf));  // any of them may be a centre
  low_ = box.min();
  inverse_cell_ = 1.0f / std::max(outer, box.sizes().maxCoeff() / kMostCells);
  cells_ = (box.sizes() * inverse_cell_).cast<int>() + Eigen::Vector3i::Ones();

  // Counting sort by cell.
  std::vector<std::size_t> cell_of_point;
  cell_of_point.reserve(kept.size());
  first_.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
  for (const int leaf : kept) {
    const Eigen::Vector3i cell = cell_of(octree.point(leaf));
    cell_of_point.push_back(index_of(cell.x(), cell.y(), cell.z()));
    ++first_[cell_of_point.back() + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  points_.resize(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    points_[static_cast<std::size_t>(next[cell_of_point[i]]++)] = {octree.point(kept[i]), kept[i]};
  }
}

Eigen::Vector3i ShellSampler::cell_of(const Eigen::Vector3f& p) const {
  return ((p - low_) * inverse_cell_).cast<int>();
}

void ShellSampler::collect(const Eigen::Vector3f& centre, std::vector<int>& shell) const {
  shell.clear();
  if (points_.empty()) return;
  const Eigen::Vector3i cell = cell_of(centre);
  const Eigen::Vector3i from = (cell - Eigen::Vector3i::Ones()).cwiseMax(0);
  const Eigen::Vector3i to =
      (cell + Eigen::Vector3i::Ones()).cwiseMin(cells_ - Eigen::Vector3i::Ones());
  for (int z = from.z(); z <= to.z(); ++z) {
    for (int y = from.y(); y <= to.y(); ++y) {
      // The cells of a row follow each other.
      const auto begin = static_cast<std::size_t>(first_[index_of(from.x(), y, z)]);
      const auto end = static_cast<std::size_t>(first_[index_of(to.x(), y, z) + 1]);
      for (std::size_t i = begin; i < end; ++i) {
        const float squared = (points_[i].p - centre).squaredNorm();
        if (squared >= squared_inner_ && squared <= squared_outer_)
          shell.push_back(points_[i].leaf);
      }
    }
  }
}

}  // namespace binpick
