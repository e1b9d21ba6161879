#pragma once

#include <Eigen/Geometry>

#include "recognition/recognition_model.h"

namespace binpick {

/// The motion of a pose that is least certain.
struct UncertainMotion {
  /// Standard deviation of the model's most uncertain surface point in its most uncertain
  /// direction, m: how far a pose that is right about what is in view may be off where nothing is.
  double displacement = 0.0;
  /// The pose error to be expected when that point is off by as much: rotation vector about the
  /// camera's axes (rad), then shift of the model's origin (m).
  Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();

  /// The pose moved until the point is off by `distance` metres.
  [[nodiscard]] Eigen::Isometry3d move(const Eigen::Isometry3d& T_camera_model,
                                       double distance) const;
};

/// Turns about an axis of revolution do not count, as in MSSD. `covariance` is that of RefinedPose.
/// Linearised. O(hull points + symmetries).
[[nodiscard]] UncertainMotion most_uncertain_motion(const RecognitionModel& model,
                                                    const Eigen::Isometry3d& T_camera_model,
                                                    const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace binpick
