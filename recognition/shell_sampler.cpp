#include "recognition/shell_sampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace binpick {

ShellSampler::ShellSampler(const SceneOctree& octree, float radius, float tolerance)
    : octree_(octree) {
  const float inner = std::max(radius - tolerance, 0.0f);
  const float outer = radius + tolerance;
  squared_inner_ = inner * inner;
  squared_outer_ = outer * outer;
  const float leaf = octree.leaf_size();
  reach_ = static_cast<int>(outer / leaf) + 1;
  // Two points in leaves (x, y, z) apart are between |x| - 1 and |x| + 1 leaves apart along x.
  const auto nearest = [](int cells) {
    return static_cast<float>(std::max(std::abs(cells) - 1, 0));
  };
  const auto farthest = [](int cells) { return static_cast<float>(std::abs(cells) + 1); };
  const auto squared = [](float x, float y, float z) { return x * x + y * y + z * z; };
  std::vector<Eigen::Vector3i> offsets;
  for (int z = -reach_; z <= reach_; ++z) {
    for (int y = -reach_; y <= reach_; ++y) {
      for (int x = -reach_; x <= reach_; ++x) {
        if (leaf * leaf * squared(nearest(x), nearest(y), nearest(z)) > squared_outer_) continue;
        if (leaf * leaf * squared(farthest(x), farthest(y), farthest(z)) < squared_inner_) continue;
        offsets.emplace_back(x, y, z);
      }
    }
  }
  Random random(derive_seed(Seed{0}, "shell offsets"));
  for (std::size_t i = offsets.size(); i > 1; --i) {  // Fisher-Yates
    std::swap(offsets[i - 1], offsets[random.index(i)]);
  }
  offsets_ = offsets.size();
  place_of_offset_.assign(index_of(Eigen::Vector3i::Constant(reach_)) + 1, -1);
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    place_of_offset_[index_of(offsets[i])] = static_cast<int>(i);
  }
}

std::vector<ShellSampler::Turn> ShellSampler::shuffled(int leaf, int start) const {
  const Eigen::Vector3i centre = octree_.cell(leaf);
  const Eigen::Vector3f p = octree_.point(leaf);
  const Eigen::Vector3i reach = Eigen::Vector3i::Constant(reach_);
  std::vector<Turn> turns;
  octree_.for_each_leaf_between(
      centre - reach, centre + reach, [&](int other, const Eigen::Vector3i& cell) {
        const int place = place_of_offset_[index_of(cell - centre)];
        if (place < 0) return;
        const float squared = (octree_.point(other) - p).squaredNorm();
        if (squared < squared_inner_ || squared > squared_outer_) return;
        turns.push_back(
            {place < start ? place + static_cast<int>(offsets_) - start : place - start, other});
      });
  std::sort(turns.begin(), turns.end(),
            [](const Turn& a, const Turn& b) { return a.place < b.place; });
  return turns;
}

}  // namespace binpick
