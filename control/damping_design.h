#pragma once

#include <Eigen/Core>

namespace binpick {

/// Damping matrices for a diagonal stiffness K and an inertia Lambda by double diagonalisation
/// (Albu-Schaeffer et al. 2003): with K v = w^2 Lambda v, every mode gets the same damping ratio.
///
/// With S = sqrt(K) and A = S Lambda^-1 S = U diag(w^2) U^T this is
///   D = S U diag(2 zeta / w) U^T S,
/// which needs the inverse inertia only. U is found by Jacobi rotations that start from the last
/// call's U: from one control tick to the next one sweep suffices. The result is converged in
/// every call; what is remembered only saves time.
template <int N>
class DampingDesign {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// @param stiffness diagonal of K, > 0.
  /// @param inverse_inertia Lambda^-1 in the axes of K; symmetric, positive semi-definite.
  /// @param damping_ratio zeta of every mode.
  /// @param inertia_cap per axis: no mode is damped as if it were heavier (singular poses).
  [[nodiscard]] Matrix damping(const Vector& stiffness, const Matrix& inverse_inertia,
                               double damping_ratio, const Vector& inertia_cap) noexcept;

  /// Forgets the last call.
  void reset() noexcept { U_.setIdentity(); }

 private:
  Matrix U_ = Matrix::Identity();
};

extern template class DampingDesign<6>;
extern template class DampingDesign<7>;

}  // namespace binpick
