#pragma once

#include <Eigen/Core>

namespace binpick {

/// Damping matrices for a diagonal stiffness K and an inertia Lambda by double diagonalisation
/// (Albu-Schaeffer et al. 2003): with K v = w^2 Lambda v, every mode gets the same damping ratio.
///
/// With S = sqrt(K) and A = S Lambda^-1 S = U diag(w^2) U^T this is
///   D = S U diag(2 zeta / w) U^T S,
/// that is, 2 zeta times the geometric mean of K and Lambda; no inverse is taken. The last call's U
/// still makes B = U^T A U nearly diagonal: Jacobi rotations zero the few entries that have grown
/// since, and a series in the rest gives B^(-1/2). The result is converged to 1e-7 in every call;
/// what is remembered only saves time.
template <int N>
class DampingDesign {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// D from the inverse inertia, for a task space.
  /// @param stiffness diagonal of K, > 0.
  /// @param inverse_inertia Lambda^-1 in the axes of K; symmetric, positive semi-definite.
  /// @param damping_ratio zeta of every mode.
  /// @param inertia_cap per axis: no mode is damped as if it were heavier (singular poses).
  [[nodiscard]] Matrix from_inverse_inertia(const Vector& stiffness, const Matrix& inverse_inertia,
                                            double damping_ratio,
                                            const Vector& inertia_cap) noexcept;

  /// D from the inertia, for the joint space: A^-1 = S^-1 M S^-1 takes the place of A.
  [[nodiscard]] Matrix from_inertia(const Vector& stiffness, const Matrix& inertia,
                                    double damping_ratio) noexcept;

  /// Forgets the last call.
  void reset() noexcept { U_.setIdentity(); }

 private:
  /// Turns U_, and B = U_^T A U_ with it, until B's off-diagonal entries are below `tolerance`,
  /// relative to its diagonal.
  void diagonalise(Matrix& B, double tolerance) noexcept;

  Matrix U_ = Matrix::Identity();
};

extern template class DampingDesign<6>;
extern template class DampingDesign<7>;

}  // namespace binpick
