#include "models/symmetry.h"

#include <algorithm>

namespace binpick {

std::optional<std::vector<Eigen::Isometry3d>> rotation_group(
    const std::vector<Eigen::Matrix3d>& generators, std::size_t max_order) {
  constexpr double kSameRotation = 1e-6;
  std::vector<Eigen::Matrix3d> rotations{Eigen::Matrix3d::Identity()};
  for (std::size_t next = 0; next < rotations.size(); ++next) {
    for (const Eigen::Matrix3d& generator : generators) {
      const Eigen::Matrix3d product = generator * rotations[next];
      const bool known =
          std::any_of(rotations.begin(), rotations.end(), [&](const Eigen::Matrix3d& rotation) {
            return (rotation - product).cwiseAbs().maxCoeff() < kSameRotation;
          });
      if (known) continue;
      if (rotations.size() == max_order) return std::nullopt;
      rotations.push_back(product);
    }
  }
  std::vector<Eigen::Isometry3d> group(rotations.size(), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < group.size(); ++i) group[i].linear() = rotations[i];
  return group;
}

}  // namespace binpick
