#pragma once

#include <Eigen/Geometry>
#include <string>

namespace binpick {

/// One recognized model instance (an element of the solution list T of Algorithm 1).
struct Detection {
  std::string model;
  /// Pose of the model in the frame of the scene that was searched. The recognizer delivers camera
  /// coordinates for a range image; whoever knows the extrinsics moves them to the world.
  Eigen::Isometry3d T_scene_model = Eigen::Isometry3d::Identity();
  double visibility = 0.0;   ///< mu_V in [0, 1], IJRR 2012, eq. (7)
  double penalty = 0.0;      ///< mu_P in [0, 1], IJRR 2012, eq. (7)
  int explained_points = 0;  ///< points of S* explained by this instance
  /// Probability that the pose is right, calibrated on generated scenes; in [0, 1].
  double confidence = 0.0;
  /// Covariance of the pose error: rotation vector about the scene's axes through the model's
  /// origin (rad), then the model's origin (m). Zero when the poses were not refined.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace binpick
