#pragma once

#include <Eigen/Geometry>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// How a pose is aligned with the range image.
struct AlignmentOptions {
  float epsilon =
      0.0f;  ///< points farther than this from their scene point along the normal are left out, m
  int points = 128;  ///< how many of the model's test points take part
  int iterations = 4;
};

/// Projective point-to-plane alignment: every model point that faces the sensor is paired with the
/// scene point seen in its pixel; the distance along the model's normal is minimised (Gauss-Newton,
/// one linear solve per iteration). Model normals are exact, scene normals are not. Allocates
/// nothing; some 20 us.
[[nodiscard]] Eigen::Isometry3f align_projectively(const ObservedScene& scene,
                                                   const RecognitionModel& model,
                                                   const Eigen::Isometry3f& T_camera_model,
                                                   const AlignmentOptions& options);

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

/// `T_camera_model` after a motion of `length` metres along such a direction.
[[nodiscard]] Eigen::Isometry3f move_along(const RecognitionModel& model,
                                           const Eigen::Isometry3f& T_camera_model,
                                           const Eigen::Matrix<float, 6, 1>& motion, float length);

/// Refines an accepted pose to the precision of the data: robust (Cauchy) point-to-plane least
/// squares over all model points by Ceres, pairs found anew between solves. `epsilon` is the scale
/// beyond which residuals stop to matter, m.
[[nodiscard]] Eigen::Isometry3d refine_pose(const ObservedScene& scene,
                                            const RecognitionModel& model,
                                            const Eigen::Isometry3d& T_camera_model,
                                            double epsilon);

}  // namespace binpick
