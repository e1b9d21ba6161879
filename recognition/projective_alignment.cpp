#include "recognition/projective_alignment.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace binpick {
namespace {

using Vector6f = Eigen::Matrix<float, 6, 1>;

}  // namespace

NormalEquations normal_equations(const ObservedScene& scene, const RecognitionModel& model,
                                 const Eigen::Isometry3f& T_camera_model, float epsilon,
                                 std::size_t count) {
  static const PointKernels kernels = best_kernels();
  return kernels.normal_equations(scene, model, T_camera_model, epsilon, count);
}

Eigen::Isometry3f move_along(const RecognitionModel& model, const Eigen::Isometry3f& T_camera_model,
                             const Vector6f& motion, float length) {
  const Eigen::Vector3f centre = T_camera_model * model.centre;
  const Eigen::Vector3f turn = motion.head<3>() * (2.0f * length / model.diameter);
  const float angle = turn.norm();
  Eigen::Isometry3f step = Eigen::Isometry3f::Identity();
  if (angle > 0.0f) step.linear() = Eigen::AngleAxisf(angle, turn / angle).toRotationMatrix();
  step.translation() = centre + length * motion.tail<3>() - step.linear() * centre;
  return step * T_camera_model;
}

Eigen::Isometry3f align_projectively(const ObservedScene& scene, const RecognitionModel& model,
                                     const Eigen::Isometry3f& T_camera_model,
                                     const AlignmentOptions& options) {
  constexpr int kLeastPairs = 6;
  constexpr float kSmallMotion = 1e-4f;  // of the diameter
  Eigen::Isometry3f T = T_camera_model;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    NormalEquations equations = normal_equations(scene, model, T, options.epsilon,
                                                 static_cast<std::size_t>(options.points));
    if (equations.pairs < kLeastPairs) break;
    // Directions that the data leave open stay where they are.
    equations.information.diagonal().array() += 0.01f * static_cast<float>(equations.pairs);
    const Vector6f motion = equations.information.ldlt().solve(equations.right);
    if (!motion.allFinite()) break;
    T = move_along(model, T, motion, 1.0f);
    if (motion.norm() < kSmallMotion * model.diameter) break;
  }
  // Rounding in single precision must not accumulate into shear.
  T.linear() = Eigen::Quaternionf(T.linear()).normalized().toRotationMatrix();
  return T;
}

}  // namespace binpick
