#include "recognition/pose_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

namespace binpick {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Symmetries closer to each other than this, rad, are those of a body of revolution.
constexpr double kTurnOfRevolution = 0.35;

/// The axis of revolution in the model's frame, if there is one.
std::optional<Eigen::Vector3d> axis_of_revolution(const RecognitionModel& model) {
  for (const Eigen::Isometry3d& symmetry : model.symmetries) {
    const Eigen::AngleAxisd turn(symmetry.linear());
    if (turn.angle() > 1e-6 && turn.angle() < kTurnOfRevolution) return turn.axis();
  }
  return std::nullopt;
}

/// The covariance when the turn about `axis` is known.
Matrix6d given_turn(const Matrix6d& covariance, const Eigen::Vector3d& axis) {
  const Eigen::Matrix<double, 6, 1> with_turn = covariance.leftCols<3>() * axis;
  const double variance = axis.dot(with_turn.head<3>());
  if (!(variance > 0.0)) return covariance;
  return covariance - with_turn * with_turn.transpose() / variance;
}

}  // namespace

Eigen::Isometry3d UncertainMotion::move(const Eigen::Isometry3d& T_camera_model,
                                        double distance) const {
  const double share = displacement > 0.0 ? distance / displacement : 0.0;
  const Eigen::Vector3d turn = share * error.head<3>();
  Eigen::Isometry3d T = T_camera_model;
  T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * T.linear();
  T.translation() += share * error.tail<3>();
  return T;
}

UncertainMotion most_uncertain_motion(const RecognitionModel& model,
                                      const Eigen::Isometry3d& T_camera_model,
                                      const Matrix6d& covariance) {
  const Eigen::Matrix3d R = T_camera_model.linear();
  const auto axis = axis_of_revolution(model);
  const Matrix6d C = axis ? given_turn(covariance, R * *axis) : covariance;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  UncertainMotion motion;
  double largest = 0.0;
  for (const Eigen::Vector3f& point : model.hull) {
    const Eigen::Vector3d p = R * point.cast<double>();  // from the model's origin
    Eigen::Matrix<double, 3, 6> J;                       // displacement = turn x p + shift
    J << 0.0, p.z(), -p.y(), 1.0, 0.0, 0.0,              //
        -p.z(), 0.0, p.x(), 0.0, 1.0, 0.0,               //
        p.y(), -p.x(), 0.0, 0.0, 0.0, 1.0;
    solver.computeDirect(J * C * J.transpose());
    if (!(solver.eigenvalues()[2] > largest)) continue;
    largest = solver.eigenvalues()[2];
    // The error's mean, given the displacement: C J' (J C J')^-1 times it.
    motion.error = C * J.transpose() * solver.eigenvectors().col(2) / std::sqrt(largest);
  }
  motion.displacement = std::sqrt(largest);
  return motion;
}

}  // namespace binpick
