#pragma once

#include <Eigen/Geometry>
#include <cstddef>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// Counts over the model points that face the sensor.
struct FacingCounts {
  int facing = 0;     ///< face the sensor and fall into the image
  int matched = 0;    ///< depth and normal agree with the scene
  int occluding = 0;  ///< in front of a measured point

  [[nodiscard]] float score() const { return static_cast<float>(matched - 2 * occluding); }
};

/// Normal equations of the point-to-plane distances for a small motion about the model's centre.
/// Turns are measured in radii (half diameters), so that all six unknowns are lengths.
struct NormalEquations {
  Eigen::Matrix<float, 6, 6> information = Eigen::Matrix<float, 6, 6>::Zero();
  Eigen::Matrix<float, 6, 1> right = Eigen::Matrix<float, 6, 1>::Zero();
  int pairs = 0;
};

/// The two inner loops of recognition over the test points of a model at a pose, `epsilon` being a
/// band along the model's normal. Both exist twice: portable, and with AVX2 eight points at a time.
/// The two give the same bits: the same operations in the same order, without fused ones.
/// Neither allocates.
struct PointKernels {
  /// Counts the test points [begin, end).
  FacingCounts (*count_facing)(const ObservedScene& scene, const RecognitionModel& model,
                               const Eigen::Isometry3f& T_camera_model, float epsilon,
                               std::size_t begin, std::size_t end);
  /// Pairs each of the first `count` test points that face the sensor with the scene point in its
  /// pixel, if its normal is similar and it lies within `epsilon`.
  NormalEquations (*normal_equations)(const ObservedScene& scene, const RecognitionModel& model,
                                      const Eigen::Isometry3f& T_camera_model, float epsilon,
                                      std::size_t count);
};

[[nodiscard]] PointKernels portable_kernels() noexcept;
/// The fastest that this processor has.
[[nodiscard]] PointKernels best_kernels() noexcept;

}  // namespace binpick
