#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "recognition/observed_scene.h"
#include "recognition/point_kernels.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// The two terms of the acceptance function mu.
struct Acceptance {
  double visibility = 0.0;  ///< mu_V = m_V / m
  double penalty = 0.0;     ///< mu_P = m_P / m

  /// mu accepts (M, T). IJRR 2012, eq. (7).
  [[nodiscard]] bool accepts(double V, double P) const { return visibility > V && penalty < P; }
};

/// mu_V and mu_P of (M, T): every model point is projected into the range image through the
/// sensor's centre of projection. It is visible if the measured point lies within `epsilon` of it
/// along the line of sight and is no part of a support plane; it occludes the scene if it lies more
/// than `epsilon` in front. IJRR 2012, section 4.2, step 6. Allocates nothing.
[[nodiscard]] Acceptance evaluate_acceptance(const ObservedScene& scene,
                                             const RecognitionModel& model,
                                             const Eigen::Isometry3f& T_camera_model,
                                             float epsilon);

/// What a quick test asks for, relative to the points that face the sensor: unlike a share of all
/// points, this does not depend on the side from which the object is seen.
struct FacingThresholds {
  float epsilon = 0.0f;     ///< band along the model's normal, m
  float visibility = 0.0f;  ///< least share of matched points
  float penalty = 0.0f;     ///< largest share of occluding points
};

/// Tests (M, T) on prefixes of 32, 128 and 256 model points and gives up as soon as the final
/// thresholds are out of reach by more than two standard deviations. Allocates nothing.
[[nodiscard]] std::optional<FacingCounts> test_in_cascade(const ObservedScene& scene,
                                                          const RecognitionModel& model,
                                                          const Eigen::Isometry3f& T_camera_model,
                                                          const FacingThresholds& thresholds);

/// Counts the test points [begin, end) with the fastest kernel that there is.
[[nodiscard]] FacingCounts count_facing(const ObservedScene& scene, const RecognitionModel& model,
                                        const Eigen::Isometry3f& T_camera_model, float epsilon,
                                        std::size_t begin, std::size_t end);

/// Whether the model reaches more than `depth` below a support plane.
[[nodiscard]] bool sinks_into_support(const ObservedScene& scene, const RecognitionModel& model,
                                      const Eigen::Isometry3f& T_camera_model, float depth);

}  // namespace binpick
