#include "recognition/point_to_plane.h"

#include <ceres/tiny_solver.h>

#include <cmath>
#include <utility>

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

/// Residuals of a small motion about `centre`, for Ceres.
class PointToPlane {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  PointToPlane(std::vector<PlaneObservation> pairs, const Eigen::Vector3d& centre)
      : pairs_(std::move(pairs)), centre_(centre) {}

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
      const PlaneObservation& pair = pairs_[static_cast<std::size_t>(i)];
      const Eigen::Vector3d n = T.linear() * pair.normal;
      const Eigen::Vector3d& q = pair.q;
      const double r = n.dot(T * pair.p - q) / pair.scale;
      const double loss = std::sqrt(std::log1p(r * r));
      const double root = std::sqrt(pair.weight);
      residuals[i] = root * std::copysign(loss, r);
      if (jacobian == nullptr) continue;
      const double slope = root * (loss > 1e-9 ? std::abs(r) / ((1.0 + r * r) * loss) : 1.0);
      // A further turn w about the moved centre c turns n and p together, which changes
      // n.(p - q) by w.(n x (c - q)).
      const Eigen::Vector3d by_turn = turn_by_parameter.transpose() * n.cross(moved_centre - q);
      for (int k = 0; k < 3; ++k) {
        jacobian[i + rows * k] = slope / pair.scale * by_turn[k];
        jacobian[i + rows * (k + 3)] = slope / pair.scale * n[k];
      }
    }
    return true;
  }

 private:
  std::vector<PlaneObservation> pairs_;
  Eigen::Vector3d centre_;
};

}  // namespace

PoseStep fit_point_to_plane(std::vector<PlaneObservation> pairs, const Eigen::Vector3d& centre) {
  const PointToPlane residuals(std::move(pairs), centre);
  ceres::TinySolver<PointToPlane> solver;
  solver.options.max_num_iterations = 8;
  ceres::TinySolver<PointToPlane>::Parameters motion =
      ceres::TinySolver<PointToPlane>::Parameters::Zero();
  solver.Solve(residuals, &motion);
  if (!motion.allFinite()) return {};
  return {motion_about(centre, motion.data()), motion.norm()};
}

}  // namespace binpick
