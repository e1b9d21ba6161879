#include "control/operational_space.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

/// In units of the cap: below this pivot the blend towards the cap begins.
constexpr double kBlendPivot = 4.0;

/// Lower Cholesky factor with the *inverse* of its diagonal on the diagonal, so that solving needs
/// no division. Returns the smallest pivot through `smallest`.
template <int N>
Eigen::Matrix<double, N, N> cholesky(const Eigen::Matrix<double, N, N>& A,
                                     double& smallest) noexcept {
  Eigen::Matrix<double, N, N> L = Eigen::Matrix<double, N, N>::Zero();
  smallest = std::numeric_limits<double>::infinity();
  for (int j = 0; j < N; ++j) {
    double pivot = A(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    smallest = std::min(smallest, pivot);
    const double inverse = 1.0 / std::sqrt(pivot);
    L(j, j) = inverse;
    for (int i = j + 1; i < N; ++i) {
      double sum = A(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum * inverse;
    }
  }
  return L;
}

/// L^-1 b.
template <int N>
Eigen::Matrix<double, N, 1> solve_lower(const Eigen::Matrix<double, N, N>& L,
                                        Eigen::Matrix<double, N, 1> b) noexcept {
  for (int j = 0; j < N; ++j) {
    b[j] *= L(j, j);
    for (int i = j + 1; i < N; ++i) b[i] -= L(i, j) * b[j];
  }
  return b;
}

/// L^-T b.
template <int N>
Eigen::Matrix<double, N, 1> solve_upper(const Eigen::Matrix<double, N, N>& L,
                                        Eigen::Matrix<double, N, 1> b) noexcept {
  for (int i = N - 1; i >= 0; --i) {
    for (int k = i + 1; k < N; ++k) b[i] -= L(k, i) * b[k];
    b[i] *= L(i, i);
  }
  return b;
}

}  // namespace

OperationalSpace::OperationalSpace(const JointMatrix& M, const Jacobian& J,
                                   const InertiaCap& cap) noexcept
    : J_(J) {
  double smallest = 0.0;
  L_ = cholesky<kArmJoints>(M, smallest);
  // X = L^-1 J^T, all six columns at once: row i of X from the rows above it.
  for (int i = 0; i < kArmJoints; ++i) {
    Eigen::Matrix<double, 1, 6> row = J.col(i).transpose();
    for (int k = 0; k < i; ++k) row -= L_(i, k) * X_.row(k);
    X_.row(i) = row * L_(i, i);
  }
  lambda_inverse_.noalias() = X_.transpose().lazyProduct(X_);

  scale_.head<3>().setConstant(std::sqrt(cap.mass));
  scale_.tail<3>().setConstant(std::sqrt(cap.inertia));
  Matrix6 scaled = scale_.asDiagonal() * lambda_inverse_ * scale_.asDiagonal();
  lambda_factor_ = cholesky<6>(scaled, smallest);
  if (!(smallest >= kBlendPivot)) {
    near_singularity_ = true;
    scaled.diagonal().array() += 1.0 - std::max(smallest, 0.0) / kBlendPivot;
    lambda_factor_ = cholesky<6>(scaled, smallest);
  }
}

Vector6 OperationalSpace::lambda_times(const Vector6& y) const noexcept {
  const Vector6 scaled = scale_.cwiseProduct(y);
  return scale_.cwiseProduct(
      solve_upper<6>(lambda_factor_, solve_lower<6>(lambda_factor_, scaled)));
}

Vector6 OperationalSpace::wrench_of(const JointVector& tau) const noexcept {
  const JointVector whitened = solve_lower<kArmJoints>(L_, tau);
  const Vector6 acceleration = X_.transpose().lazyProduct(whitened);
  return lambda_times(acceleration);
}

JointVector OperationalSpace::acceleration_of(const JointVector& tau) const noexcept {
  return solve_upper<kArmJoints>(L_, solve_lower<kArmJoints>(L_, tau));
}

JointVector OperationalSpace::joint_velocity_of(const Vector6& v) const noexcept {
  const Vector6 momentum = lambda_times(v);
  return solve_upper<kArmJoints>(L_, X_.lazyProduct(momentum));
}

JointVector OperationalSpace::null_space_part(const JointVector& tau) const noexcept {
  const Vector6 wrench = wrench_of(tau);
  return tau - J_.transpose().lazyProduct(wrench);
}

}  // namespace binpick
