#include "control/operational_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binpick {
namespace {

/// In units of the cap: below this pivot the blend towards the cap begins.
constexpr double kBlendPivot = 4.0;

/// The inverse of A's lower Cholesky factor, transposed: A^-1 = U U^T. Returns the smallest pivot
/// through `smallest`. Everything runs along columns, which the processor takes two numbers at a
/// time.
template <int N>
Eigen::Matrix<double, N, N> inverse_factor(Eigen::Matrix<double, N, N> A,
                                           double& smallest) noexcept {
  smallest = std::numeric_limits<double>::infinity();
  Eigen::Matrix<double, N, N> U = Eigen::Matrix<double, N, N>::Identity();
  for (int j = 0; j < N; ++j) {
    smallest = std::min(smallest, A(j, j));
    const double inverse = 1.0 / std::sqrt(A(j, j));
    A.col(j) *= inverse;  // column j of the factor
    U.col(j) *= inverse;
    for (int i = j + 1; i < N; ++i) {
      const double factor = A(i, j);
      A.col(i) -= factor * A.col(j);
      U.col(i) -= factor * U.col(j);
    }
  }
  return U;
}

/// A U for an upper triangular U.
template <int Rows, int N>
Eigen::Matrix<double, Rows, N> times_triangle(const Eigen::Matrix<double, Rows, N>& A,
                                              const Eigen::Matrix<double, N, N>& U) noexcept {
  Eigen::Matrix<double, Rows, N> product;
  for (int j = 0; j < N; ++j) {
    product.col(j) = A.col(0) * U(0, j);
    for (int k = 1; k <= j; ++k) product.col(j) += A.col(k) * U(k, j);
  }
  return product;
}

/// U U^T for an upper triangular U.
template <int N>
Eigen::Matrix<double, N, N> triangle_squared(const Eigen::Matrix<double, N, N>& U) noexcept {
  Eigen::Matrix<double, N, N> square;
  for (int j = 0; j < N; ++j) {
    square.col(j) = U.col(j) * U(j, j);
    for (int k = j + 1; k < N; ++k) square.col(j) += U.col(k) * U(j, k);
  }
  return square;
}

}  // namespace

OperationalSpace::OperationalSpace(const JointMatrix& M, const Jacobian& J,
                                   const InertiaCap& cap) noexcept
    : J_(J) {
  double smallest = 0.0;
  const JointMatrix U = inverse_factor<kArmJoints>(M, smallest);
  M_inverse_ = triangle_squared<kArmJoints>(U);
  const Jacobian JU = times_triangle<6, kArmJoints>(J, U);
  lambda_inverse_ = JU.lazyProduct(JU.transpose());

  Vector6 scale;
  scale.head<3>().setConstant(std::sqrt(cap.mass));
  scale.tail<3>().setConstant(std::sqrt(cap.inertia));
  Matrix6 scaled = scale.asDiagonal() * lambda_inverse_ * scale.asDiagonal();
  Matrix6 factor = inverse_factor<6>(scaled, smallest);
  if (!(smallest >= kBlendPivot)) {
    near_singularity_ = true;
    scaled.diagonal().array() += 1.0 - std::max(smallest, 0.0) / kBlendPivot;
    factor = inverse_factor<6>(scaled, smallest);
  }
  const Matrix6 scaled_factor = scale.asDiagonal() * factor;
  lambda_ = triangle_squared<6>(scaled_factor);
}

Vector6 OperationalSpace::wrench_of(const JointVector& tau) const noexcept {
  const JointVector acceleration = acceleration_of(tau);
  const Vector6 tool_acceleration = J_.lazyProduct(acceleration);
  return lambda_times(tool_acceleration);
}

JointVector OperationalSpace::joint_velocity_of(const Vector6& v) const noexcept {
  const Vector6 momentum = lambda_times(v);
  const JointVector joint_momentum = J_.transpose().lazyProduct(momentum);
  return acceleration_of(joint_momentum);
}

JointVector OperationalSpace::null_space_part(const JointVector& tau) const noexcept {
  const Vector6 wrench = wrench_of(tau);
  return tau - J_.transpose().lazyProduct(wrench);
}

}  // namespace binpick
