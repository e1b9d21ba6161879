#pragma once

#include <Eigen/Geometry>
#include <cstddef>

#include "recognition/observed_scene.h"
#include "recognition/point_kernels.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// The equations over the first `count` test points; pairs farther apart than `epsilon` along the
/// model's normal take no part.
[[nodiscard]] NormalEquations normal_equations(const ObservedScene& scene,
                                               const RecognitionModel& model,
                                               const Eigen::Isometry3f& T_camera_model,
                                               float epsilon, std::size_t count);

/// How a pose is aligned with the range image.
struct AlignmentOptions {
  float epsilon =
      0.0f;  ///< points farther than this from their scene point along the normal are left out, m
  int points = 128;  ///< how many of the model's test points take part
  int iterations = 4;
};

/// For a pose that is about right, of a model that agrees with the scene to within `tolerance`, m.
[[nodiscard]] inline AlignmentOptions fine_alignment(float tolerance) {
  return {1.5f * tolerance, 512, 6};
}

/// Projective point-to-plane alignment: every model point that faces the sensor is paired with the
/// scene point seen in its pixel; the distance along the model's normal is minimised (Gauss-Newton,
/// one linear solve per iteration). Model normals are exact, scene normals are not. Allocates
/// nothing; some 20 us.
[[nodiscard]] Eigen::Isometry3f align_projectively(const ObservedScene& scene,
                                                   const RecognitionModel& model,
                                                   const Eigen::Isometry3f& T_camera_model,
                                                   const AlignmentOptions& options);

/// `T_camera_model` after a motion of `length` metres along a direction of the normal equations.
[[nodiscard]] Eigen::Isometry3f move_along(const RecognitionModel& model,
                                           const Eigen::Isometry3f& T_camera_model,
                                           const Eigen::Matrix<float, 6, 1>& motion, float length);

}  // namespace binpick
