#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace binpick {

/// A point of the model, and the plane in which it should lie: through the measured point `q`, with
/// the model's normal. Camera frame, m.
struct PlaneObservation {
  Eigen::Vector3d p;
  Eigen::Vector3d normal;
  Eigen::Vector3d q;
  double scale = 1.0;   ///< of the residual, m: what is much larger is an outlier
  double weight = 1.0;  ///< of the robust, dimensionless cost
};

/// A small motion in the camera frame.
struct PoseStep {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  double length = 0.0;  ///< norm of rotation vector (rad) and translation (m) together
};

/// The motion of the points that minimises the robust (Cauchy) sum of squared distances from their
/// planes, by Levenberg-Marquardt (Ceres). Turns are taken about `centre`. The identity when the
/// planes fix no motion.
[[nodiscard]] PoseStep fit_point_to_plane(std::vector<PlaneObservation> pairs,
                                          const Eigen::Vector3d& centre);

}  // namespace binpick
