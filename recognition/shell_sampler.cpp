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
  const int reach = static_cast<int>(outer / leaf) + 1;
  // Two points in leaves (x, y, z) apart are between |x| - 1 and |x| + 1 leaves apart along x.
  const auto nearest = [](int cells) {
    return static_cast<float>(std::max(std::abs(cells) - 1, 0));
  };
  const auto farthest = [](int cells) { return static_cast<float>(std::abs(cells) + 1); };
  const auto squared = [](float x, float y, float z) { return x * x + y * y + z * z; };
  for (int z = -reach; z <= reach; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        if (leaf * leaf * squared(nearest(x), nearest(y), nearest(z)) > squared_outer_) continue;
        if (leaf * leaf * squared(farthest(x), farthest(y), farthest(z)) < squared_inner_) continue;
        offsets_.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y),
                            static_cast<std::int16_t>(z)});
      }
    }
  }
  Random random(derive_seed(Seed{0}, "shell offsets"));
  for (std::size_t i = offsets_.size(); i > 1; --i) {  // Fisher-Yates
    std::swap(offsets_[i - 1], offsets_[random.index(i)]);
  }
}

}  // namespace binpick
