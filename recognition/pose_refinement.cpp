#include "recognition/pose_refinement.h"

#include <ceres/tiny_solver.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "recognition/correspondence.h"
#include "recognition/projective_alignment.h"

namespace binpick {
namespace {

/// The rotation vector's rotation about `centre`, then a translation.
Eigen::Isometry3d motion_about(const Eigen::Vector3d& centre, const double* motion) {
  const Eigen::Vector3d w(motion[0], motion[1], motion[2]);
  const double angle = w.norm();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (angle > 0.0) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = centre + Eigen::Vector3d(motion[3], motion[4], motion[5]) - T.linear() * centre;
  return T;
}

/// How a rotation vector's change turns the rotated frame, seen from outside: the left Jacobian of
/// SO(3).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  Eigen::Matrix3d cross;
  cross << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() + 0.5 * cross;
  return Eigen::Matrix3d::Identity() + (1.0 - std::cos(angle)) / (angle * angle) * cross +
         (angle - std::sin(angle)) / std::pow(angle, 3) * cross * cross;
}

/// Point-to-plane residuals of a small motion about `centre`, for Ceres.
class PointToPlane {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  PointToPlane(std::vector<Correspondence> pairs, const Eigen::Vector3d& centre, double scale)
      : pairs_(std::move(pairs)), centre_(centre), scale_(scale) {}

  [[nodiscard]] int NumResiduals() const { return static_cast<int>(pairs_.size()); }

  /// Cauchy's loss as a residual: sqrt(log(1 + (r / s)^2)) with the sign of r. Its square is the
  /// robust cost. `jacobian` is column-major, residuals x 6.
  bool operator()(const double* motion, double* residuals, double* jacobian) const {
    const Eigen::Isometry3d T = motion_about(centre_, motion);
    const Eigen::Matrix3d turn_by_parameter =
        left_jacobian(Eigen::Vector3d(motion[0], motion[1], motion[2]));
    const Eigen::Vector3d moved_centre = T * centre_;
    const auto rows = static_cast<Eigen::Index>(pairs_.size());
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Correspondence& pair = pairs_[static_cast<std::size_t>(i)];
      const Eigen::Vector3d n = T.linear() * pair.normal.cast<double>();
      const Eigen::Vector3d q = pair.q_camera.cast<double>();
      const double r = n.dot(T * pair.p_camera.cast<double>() - q) / scale_;
      const double loss = std::sqrt(std::log1p(r * r));
      residuals[i] = std::copysign(loss, r);
      if (jacobian == nullptr) continue;
      const double slope = loss > 1e-9 ? std::abs(r) / ((1.0 + r * r) * loss) : 1.0;
      // A further turn w about the moved centre c turns n and p together, which changes
      // n.(p - q) by w.(n x (c - q)).
      const Eigen::Vector3d by_turn = turn_by_parameter.transpose() * n.cross(moved_centre - q);
      for (int k = 0; k < 3; ++k) {
        jacobian[i + rows * k] = slope / scale_ * by_turn[k];
        jacobian[i + rows * (k + 3)] = slope / scale_ * n[k];
      }
    }
    return true;
  }

 private:
  std::vector<Correspondence> pairs_;
  Eigen::Vector3d centre_;
  double scale_;
};

}  // namespace

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
    std::vector<Correspondence> pairs;
    for_each_correspondence(scene, model, T.cast<float>(), static_cast<float>(3.0 * epsilon),
                            model.test_points.size(),
                            [&](const Correspondence& pair) { pairs.push_back(pair); });
    if (pairs.size() < kLeastPairs) break;
    const Eigen::Vector3d centre = T * model.centre.cast<double>();
    const PointToPlane residuals(std::move(pairs), centre, epsilon);
    ceres::TinySolver<PointToPlane> solver;
    solver.options.max_num_iterations = 8;
    ceres::TinySolver<PointToPlane>::Parameters motion =
        ceres::TinySolver<PointToPlane>::Parameters::Zero();
    solver.Solve(residuals, &motion);
    if (!motion.allFinite()) break;
    T = motion_about(centre, motion.data()) * T;
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    if (motion.norm() < 1e-6) break;
  }
  return T;
}

}  // namespace binpick
