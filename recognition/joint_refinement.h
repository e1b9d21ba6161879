#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "recognition/detection_selection.h"
#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"
#include "recognition/sensor_estimate.h"

namespace binpick {

/// A pose with its uncertainty.
struct RefinedPose {
  Eigen::Isometry3d T_camera_model = Eigen::Isometry3d::Identity();
  /// Of the pose error: rotation vector about the camera's axes through the model's origin (rad),
  /// then the model's origin (m).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// What limits the precision of a pose besides the pixels' noise. Systematic errors do not average
/// out over neighbouring pixels.
struct RefinementOptions {
  /// Shape error of a model, standard deviation, of its diameter; alike over `patch`.
  double shape_error = 0.003;
  double patch = 0.3;  ///< of the diameter
  /// Slow error of the sensor's depth, of the depth.
  double depth_error = 0.0012;
  /// How far a step of depth lies beside a silhouette, pixels: standard deviation of one, and of
  /// what is common to all of an object.
  double step_error = 1.0;
  double common_step_error = 0.4;
};

/// Refines the poses of one consistent set together: every pixel is assigned to the one object that
/// explains it, and each object's pixels pull it by robust point-to-plane least squares over all
/// matched pixels of its rendering, the steps of depth along its silhouette across the line of
/// sight. Given the assignment the problem separates into one of six unknowns per object; objects
/// touch each other's solutions through the assignment, renewed between the solves.
///
/// The covariance is the inverse of the information of all observations, scaled by noise and its
/// spatial correlation, plus what is systematic.
[[nodiscard]] std::vector<RefinedPose> refine_jointly(std::span<const RecognitionModel> models,
                                                      const ObservedScene& scene,
                                                      const SensorEstimate& sensor, double dilation,
                                                      std::span<const Candidate> selected, int jobs,
                                                      const RefinementOptions& options = {});

/// As refine_jointly, from where `selected` are, of those with an index in `moved` alone: the
/// others stay at their `poses`, on what they explain there.
void refine_moved(std::span<const RecognitionModel> models, const ObservedScene& scene,
                  const SensorEstimate& sensor, double dilation,
                  std::span<const Candidate> selected, std::span<const int> moved,
                  std::vector<RefinedPose>& poses, int jobs, const RefinementOptions& options = {});

}  // namespace binpick
