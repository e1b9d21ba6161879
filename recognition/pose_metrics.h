#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace binpick {

/// Distances between an estimated and a true pose of the same model, metres. `symmetries` are the
/// poses that shape cannot tell apart (T_model_equivalent); an empty span means the identity alone.

/// Maximum symmetry-aware surface distance (Hodan et al., BOP 2020): the least over the symmetries
/// of the largest distance between corresponding points. O(symmetries x points).
[[nodiscard]] double mssd(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
                          std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Isometry3d> symmetries);

/// Average distance of corresponding points, least over the symmetries (ADD with symmetries;
/// Hinterstoisser et al., ACCV 2012, for one symmetry).
[[nodiscard]] double add(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
                         std::span<const Eigen::Vector3f> points,
                         std::span<const Eigen::Isometry3d> symmetries);

/// Average distance to the closest point (ADI; Hinterstoisser et al., ACCV 2012). O(points^2).
[[nodiscard]] double adi(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
                         std::span<const Eigen::Vector3f> points);

/// Root mean square error of corresponding points. IJRR 2012, eq. (16).
[[nodiscard]] double rms_error(std::span<const Eigen::Vector3d> p,
                               std::span<const Eigen::Vector3d> q, const Eigen::Isometry3d& T);

/// The symmetry under which the estimate is closest to the truth: angle, rad, and distance between
/// the model origins, m.
struct PoseError {
  double rotation = 0.0;
  double translation = 0.0;
};
[[nodiscard]] PoseError pose_error(const Eigen::Isometry3d& T_estimated,
                                   const Eigen::Isometry3d& T_true,
                                   std::span<const Eigen::Isometry3d> symmetries);

}  // namespace binpick
