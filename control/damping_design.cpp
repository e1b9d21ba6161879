#include "control/damping_design.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

/// Off-diagonal entries, relative to the diagonal, that are left to the series of inverse_root();
/// its error is their third power. Between two ticks few entries grow beyond it.
constexpr double kSmall = 1e-2;
/// Those that count as zero where single modes are looked at.
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

/// B^(-1/2) of a B whose off-diagonal entries are small. In first order, with r_i = sqrt(B_ii),
/// Z_ij = -B_ij / (r_i r_j (r_i + r_j)); the residual 1 - Z B Z, divided by r_i + r_j, is what Z
/// lacks in second order.
template <int N>
Eigen::Matrix<double, N, N> inverse_root(const Eigen::Matrix<double, N, N>& B) noexcept {
  const Eigen::Matrix<double, N, 1> r = B.diagonal().cwiseSqrt();
  Eigen::Matrix<double, N, N> Z;
  Eigen::Matrix<double, N, N> weight;  // 1 / (r_i + r_j)
  for (int j = 0; j < N; ++j) {
    const Eigen::Matrix<double, N, 1> sum = r.array() + r[j];
    weight.col(j) = sum.cwiseInverse();
    Z.col(j) = -B.col(j).cwiseProduct(weight.col(j)).cwiseQuotient(r * r[j]);
  }
  Z.diagonal() = r.cwiseInverse();
  const Eigen::Matrix<double, N, N> ZB = Z.lazyProduct(B);
  Eigen::Matrix<double, N, N> residual = -ZB.lazyProduct(Z);
  residual.diagonal().array() += 1.0;
  Z += residual.cwiseProduct(weight);
  return Z;
}

}  // namespace

template <int N>
void DampingDesign<N>::diagonalise(Matrix& B, double tolerance) noexcept {
  bool done = false;
  for (int sweep = 0; sweep < kMaxSweeps && !done; ++sweep) {
    done = true;
    // Every pair once. The pairs of a round share no index: the processor turns them side by side.
    for (int round = 0; round < N; ++round) {
      for (int p = 0; p < N; ++p) {
        const int q = (round - p + N) % N;
        if (p >= q) continue;
        const double b_pq = B(p, q);
        // Written so that NaN ends the loop: the caller refuses what comes out.
        if (!(b_pq * b_pq > tolerance * tolerance * std::abs(B(p, p) * B(q, q)))) continue;
        const Rotation rotation = zeroing(B(p, p), b_pq, B(q, q));
        rotate_symmetric<N>(B, p, q, rotation);
        rotate_columns<N>(U_, p, q, rotation);
        done = false;
      }
    }
  }
  if (!B.diagonal().allFinite()) U_.setIdentity();
}

template <int N>
typename DampingDesign<N>::Matrix DampingDesign<N>::from_inverse_inertia(
    const Vector& stiffness, const Matrix& inverse_inertia, double damping_ratio,
    const Vector& inertia_cap) noexcept {
  const Vector S = stiffness.cwiseSqrt();
  Matrix SU = S.asDiagonal() * U_;
  Matrix B = SU.transpose().lazyProduct(inverse_inertia.lazyProduct(SU).eval());
  diagonalise(B, kSmall);
  const Vector slowest = stiffness.cwiseQuotient(inertia_cap);
  if ((B.diagonal() - U_.cwiseAbs2().transpose().lazyProduct(slowest)).minCoeff() < 0.0) {
    diagonalise(B, kTolerance);
    B.diagonal() = B.diagonal().cwiseMax(U_.cwiseAbs2().transpose().lazyProduct(slowest));
  }
  SU = S.asDiagonal() * U_;
  const Matrix weighted = SU.lazyProduct(inverse_root<N>(B));
  return 2.0 * damping_ratio * weighted.lazyProduct(SU.transpose());
}

template <int N>
typename DampingDesign<N>::Matrix DampingDesign<N>::from_inertia(const Vector& stiffness,
                                                                 const Matrix& inertia,
                                                                 double damping_ratio) noexcept {
  const Vector S = stiffness.cwiseSqrt();
  const Matrix scaled_U = S.cwiseInverse().asDiagonal() * U_;
  Matrix B = scaled_U.transpose().lazyProduct(inertia.lazyProduct(scaled_U).eval());
  diagonalise(B, kSmall);
  const Matrix SU = S.asDiagonal() * U_;
  const Matrix root = B.lazyProduct(inverse_root<N>(B));
  const Matrix weighted = SU.lazyProduct(root);
  return 2.0 * damping_ratio * weighted.lazyProduct(SU.transpose());
}

template class DampingDesign<6>;
template class DampingDesign<7>;

}  // namespace binpick
