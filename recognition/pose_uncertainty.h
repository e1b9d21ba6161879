#pragma once

#include <Eigen/Geometry>

#include "recognition/recognition_model.h"

namespace binpick {

/// Standard deviation of the model's most uncertain surface point in its most uncertain direction,
/// m: how far a pose that is right about what is in view may be off where nothing is. Turns about
/// an axis of revolution do not count, as in MSSD. `covariance` is that of RefinedPose. Linearised.
/// O(hull points + symmetries).
[[nodiscard]] double largest_displacement(const RecognitionModel& model,
                                          const Eigen::Isometry3d& T_camera_model,
                                          const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace binpick
