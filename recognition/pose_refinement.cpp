#include "recognition/pose_refinement.h"

#include <Eigen/Eigenvalues>
#include <vector>

#include "recognition/correspondence.h"
#include "recognition/point_to_plane.h"
#include "recognition/projective_alignment.h"

namespace binpick {
OpenDirections open_directions(const ObservedScene& scene, const RecognitionModel& model,
                               const Eigen::Isometry3f& T_camera_model, float epsilon) {
  constexpr float kWeak = 0.03f;  // of the information of a direction that every point fixes
  OpenDirections open;
  const NormalEquations equations =
      normal_equations(scene, model, T_camera_model, epsilon, model.test_points.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<float, 6, 6>> solver(equations.information);
  open.motions = solver.eigenvectors();
  while (open.count < 6 &&
         solver.eigenvalues()[open.count] < kWeak * static_cast<float>(equations.pairs)) {
    ++open.count;
  }
  return open;
}

Eigen::Isometry3d refine_pose(const ObservedScene& scene, const RecognitionModel& model,
                              const Eigen::Isometry3d& T_camera_model, double epsilon) {
  constexpr int kPairings = 4;
  constexpr std::size_t kLeastPairs = 12;
  Eigen::Isometry3d T = T_camera_model;
  for (int i = 0; i < kPairings; ++i) {
    std::vector<PlaneObservation> pairs;
    for_each_correspondence(
        scene, model, T.cast<float>(), static_cast<float>(3.0 * epsilon), model.test_points.size(),
        [&](const Correspondence& pair) {
          pairs.push_back({pair.p_camera.cast<double>(), pair.normal.cast<double>(),
                           pair.q_camera.cast<double>(), epsilon});
        });
    if (pairs.size() < kLeastPairs) break;
    const PoseStep step = fit_point_to_plane(std::move(pairs), T * model.centre.cast<double>());
    T = step.motion * T;
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    if (step.length < 1e-6) break;
  }
  return T;
}

}  // namespace binpick
