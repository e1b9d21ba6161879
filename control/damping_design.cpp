#include "control/damping_design.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

/// Off-diagonal entries smaller than this, relative to the diagonal, count as zero. They enter D
/// with the same relative size.
constexpr double kTolerance = 1e-7;
constexpr int kMaxSweeps = 20;

/// Cosine and sine of a plane rotation.
struct Rotation {
  double tangent;
  double c;
  double s;
};

/// The rotation that zeroes the off-diagonal entry of [[a_pp, a_pq], [a_pq, a_qq]] (Golub & Van
/// Loan, section 8.5). A small one, as nearly all are from tick to tick, by series: the tangent to
/// third order, which the next sweep corrects, but c to rounding, so that U stays orthogonal.
inline Rotation zeroing(double a_pp, double a_pq, double a_qq) noexcept {
  const double difference = a_qq - a_pp;
  Rotation rotation;
  if (std::abs(a_pq) < 0.01 * std::abs(difference)) {
    const double ratio = a_pq / difference;
    const double t = ratio * (1.0 - ratio * ratio);
    const double t2 = t * t;
    rotation = {t, 1.0 - t2 * (0.5 - t2 * (0.375 - 0.3125 * t2)), 0.0};
  } else {
    const double theta = 0.5 * difference / a_pq;
    const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
    rotation = {t, 1.0 / std::sqrt(t * t + 1.0), 0.0};
  }
  rotation.s = rotation.tangent * rotation.c;
  return rotation;
}

/// Turns columns p and q.
template <int N>
inline void rotate_columns(Eigen::Matrix<double, N, N>& A, int p, int q,
                           const Rotation& by) noexcept {
  const Eigen::Matrix<double, N, 1> column_p = A.col(p);
  A.col(p) = by.c * column_p - by.s * A.col(q);
  A.col(q) = by.s * column_p + by.c * A.col(q);
}

/// R^T A R for symmetric A.
template <int N>
inline void rotate_symmetric(Eigen::Matrix<double, N, N>& A, int p, int q,
                             const Rotation& by) noexcept {
  const double a_pp = A(p, p);
  const double a_pq = A(p, q);
  const double a_qq = A(q, q);
  rotate_columns<N>(A, p, q, by);
  A.row(p) = A.col(p).transpose();
  A.row(q) = A.col(q).transpose();
  const double c2 = by.c * by.c;
  const double s2 = by.s * by.s;
  const double cs = by.c * by.s;
  A(p, p) = c2 * a_pp - 2.0 * cs * a_pq + s2 * a_qq;
  A(q, q) = s2 * a_pp + 2.0 * cs * a_pq + c2 * a_qq;
  A(p, q) = A(q, p) = (c2 - s2) * a_pq + cs * (a_pp - a_qq);
}

}  // namespace

template <int N>
typename DampingDesign<N>::Vector DampingDesign<N>::diagonalise(const Matrix& A) noexcept {
  const Matrix AU = A.lazyProduct(U_);
  Matrix nearly_diagonal = U_.transpose().lazyProduct(AU);
  bool done = false;
  for (int sweep = 0; sweep < kMaxSweeps && !done; ++sweep) {
    done = true;
    // Every pair once. The pairs of a round share no index: the processor turns them side by side.
    for (int round = 0; round < N; ++round) {
      for (int p = 0; p < N; ++p) {
        const int q = (round - p + N) % N;
        if (p >= q) continue;
        const double a_pq = nearly_diagonal(p, q);
        const double scale = nearly_diagonal(p, p) * nearly_diagonal(q, q);
        // Written so that NaN ends the loop: the caller refuses what comes out.
        if (!(a_pq * a_pq > kTolerance * kTolerance * std::abs(scale))) continue;
        const Rotation rotation = zeroing(nearly_diagonal(p, p), a_pq, nearly_diagonal(q, q));
        rotate_symmetric<N>(nearly_diagonal, p, q, rotation);
        rotate_columns<N>(U_, p, q, rotation);
        done = false;
      }
    }
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
