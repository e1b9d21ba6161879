#include "control/damping_design.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

/// Off-diagonal entries smaller than this, relative to the diagonal, count as zero. They enter D
/// with the same relative size.
constexpr double kTolerance = 1e-7;
constexpr int kMaxSweeps = 20;

/// One Jacobi rotation in the plane (p, q) that zeroes A(p, q) (Golub & Van Loan, section 8.5).
template <int N>
void rotate(Eigen::Matrix<double, N, N>& A, Eigen::Matrix<double, N, N>& U, int p, int q) noexcept {
  const double theta = 0.5 * (A(q, q) - A(p, p)) / A(p, q);
  const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
  const double c = 1.0 / std::sqrt(t * t + 1.0);
  const double s = t * c;
  for (int k = 0; k < N; ++k) {
    const double a_kp = A(k, p);
    const double a_kq = A(k, q);
    A(k, p) = c * a_kp - s * a_kq;
    A(k, q) = s * a_kp + c * a_kq;
  }
  for (int k = 0; k < N; ++k) {
    const double a_pk = A(p, k);
    const double a_qk = A(q, k);
    A(p, k) = c * a_pk - s * a_qk;
    A(q, k) = s * a_pk + c * a_qk;
  }
  for (int k = 0; k < N; ++k) {
    const double u_kp = U(k, p);
    const double u_kq = U(k, q);
    U(k, p) = c * u_kp - s * u_kq;
    U(k, q) = s * u_kp + c * u_kq;
  }
}

}  // namespace

template <int N>
typename DampingDesign<N>::Vector DampingDesign<N>::diagonalise(const Matrix& A) noexcept {
  const Matrix AU = A.lazyProduct(U_);
  Matrix nearly_diagonal = U_.transpose().lazyProduct(AU);
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool done = true;
    for (int p = 0; p < N - 1; ++p) {
      for (int q = p + 1; q < N; ++q) {
        const double a_pq = nearly_diagonal(p, q);
        const double scale = nearly_diagonal(p, p) * nearly_diagonal(q, q);
        // Written so that NaN ends the loop: the caller refuses what comes out.
        if (!(a_pq * a_pq > kTolerance * kTolerance * std::abs(scale))) continue;
        rotate<N>(nearly_diagonal, U_, p, q);
        done = false;
      }
    }
    if (done) break;
  }
  const Vector eigenvalues = nearly_diagonal.diagonal();
  if (!eigenvalues.allFinite()) U_.setIdentity();
  return eigenvalues;
}

template <int N>
typename DampingDesign<N>::Matrix DampingDesign<N>::from_inverse_inertia(
    const Vector& stiffness, const Matrix& inverse_inertia, double damping_ratio,
    const Vector& inertia_cap) noexcept {
  const Vector S = stiffness.cwiseSqrt();
  const Matrix A = S.asDiagonal() * inverse_inertia * S.asDiagonal();
  const Vector squared_frequency = diagonalise(A);
  const Vector slowest = stiffness.cwiseQuotient(inertia_cap);
  const Matrix SU = S.asDiagonal() * U_;
  Matrix weighted;
  for (int i = 0; i < N; ++i) {
    const double floor = U_.col(i).cwiseAbs2().dot(slowest);
    const double w2 = std::max(squared_frequency[i], floor);
    weighted.col(i) = SU.col(i) * (2.0 * damping_ratio / std::sqrt(w2));
  }
  return weighted.lazyProduct(SU.transpose());
}

template <int N>
typename DampingDesign<N>::Matrix DampingDesign<N>::from_inertia(const Vector& stiffness,
                                                                 const Matrix& inertia,
                                                                 double damping_ratio) noexcept {
  const Vector S = stiffness.cwiseSqrt();
  const Vector S_inverse = S.cwiseInverse();
  const Matrix A_inverse = S_inverse.asDiagonal() * inertia * S_inverse.asDiagonal();
  const Vector squared_period = diagonalise(A_inverse);
  const Matrix SU = S.asDiagonal() * U_;
  Matrix weighted;
  for (int i = 0; i < N; ++i) {
    weighted.col(i) = SU.col(i) * (2.0 * damping_ratio * std::sqrt(squared_period[i]));
  }
  return weighted.lazyProduct(SU.transpose());
}

template class DampingDesign<6>;
template class DampingDesign<7>;

}  // namespace binpick
