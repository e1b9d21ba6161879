#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "models/range_image.h"

namespace binpick {

/// Distances between an estimated and a true pose of the same model, metres. `symmetries` are the
/// poses that shape cannot tell apart (T_model_equivalent); an empty span means the identity alone.

/// Maximum symmetry-aware surface distance (Hodan et al., BOP 2020): the least over the symmetries
/// of the largest distance between corresponding points. O(symmetries x points).
[[nodiscard]] double mssd(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
                          std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Isometry3d> symmetries);

/// Maximum symmetry-aware projection distance (BOP 2020): as MSSD, but in the image of `camera`,
/// pixels. Infinite when a point of either pose is not in front of the camera.
[[nodiscard]] double mspd(const Eigen::Isometry3d& T_camera_estimated,
                          const Eigen::Isometry3d& T_camera_true,
                          std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Isometry3d> symmetries,
                          const CameraIntrinsics& camera);

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

/// Share of a model's surface that the sensor does not see. IJRR 2012, eq. (15).
[[nodiscard]] constexpr double occlusion(double visible_area, double total_area) {
  return 1.0 - visible_area / total_area;
}

/// Which estimate is which true instance: estimates are taken in order of their scores, best first,
/// each gets the free instance of least error strictly below `limit`, if any (BOP conventions).
/// `error` compares an estimate with an instance; infinity for different models.
struct InstanceMatching {
  std::vector<std::ptrdiff_t> truth_of;  ///< per estimate, -1 for a false positive
  std::vector<bool> found;               ///< per true instance

  [[nodiscard]] std::size_t true_positives() const;
  [[nodiscard]] std::size_t false_positives() const { return truth_of.size() - true_positives(); }
  /// 1 when there is nothing to be found.
  [[nodiscard]] double recall() const;
};
[[nodiscard]] InstanceMatching match_instances(
    std::span<const double> scores, std::size_t instances, double limit,
    const std::function<double(std::size_t estimate, std::size_t instance)>& error);

}  // namespace binpick
