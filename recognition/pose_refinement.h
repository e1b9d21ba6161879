#pragma once

#include <Eigen/Geometry>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// Motions of a pose that the points of the visible surface leave nearly open: sliding along a flat
/// face, turning about its normal. Each is a turn about the model's centre, in radii (half
/// diameters), and a translation; unit length. O(test points).
struct OpenDirections {
  int count = 0;
  Eigen::Matrix<float, 6, 6> motions;  ///< the first `count` columns
};
[[nodiscard]] OpenDirections open_directions(const ObservedScene& scene,
                                             const RecognitionModel& model,
                                             const Eigen::Isometry3f& T_camera_model,
                                             float epsilon);

/// Refines an accepted pose to the precision of the data: robust (Cauchy) point-to-plane least
/// squares over all model points by Ceres, pairs found anew between solves. `epsilon` is the scale
/// beyond which residuals stop to matter, m.
[[nodiscard]] Eigen::Isometry3d refine_pose(const ObservedScene& scene,
                                            const RecognitionModel& model,
                                            const Eigen::Isometry3d& T_camera_model,
                                            double epsilon);

}  // namespace binpick
