#pragma once

#include <Eigen/Core>

#include "control/arm_model.h"

namespace binpick {

/// Linear part first, then angular: a wrench (N, Nm), a twist (m/s, rad/s) or their stiffnesses.
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Largest apparent inertia of the tool centre that the controller reckons with. Towards a
/// singularity the true one grows without bound, and with it every torque computed from it.
struct InertiaCap {
  double mass = 50.0;    ///< kg; in working poses the arm shows some 10 kg
  double inertia = 5.0;  ///< kg m^2; there 0.5
};

/// The arm's inertia seen at the tool centre, world axes (Khatib 1987), and the dynamically
/// consistent projections that follow from it. With M = L L^T and U = L^-T, the inverses are
/// M^-1 = U U^T and J M^-1 J^T = (J U) (J U)^T: symmetric and never indefinite.
class OperationalSpace {
 public:
  OperationalSpace() noexcept = default;
  /// About 1000 multiply-adds; allocates nothing.
  /// @param M joint inertia that the controller acts through: the links', plus the shaped motor
  ///   inertia where joints are elastic.
  OperationalSpace(const JointMatrix& M, const Jacobian& J, const InertiaCap& cap = {}) noexcept;

  /// J M^-1 J^T.
  [[nodiscard]] const Matrix6& lambda_inverse() const noexcept { return lambda_inverse_; }
  /// M^-1.
  [[nodiscard]] const JointMatrix& M_inverse() const noexcept { return M_inverse_; }
  /// Lambda y, with Lambda = (J M^-1 J^T)^-1, capped near singularities.
  [[nodiscard]] Vector6 lambda_times(const Vector6& y) const noexcept {
    return lambda_.lazyProduct(y);
  }
  /// M^-1 tau.
  [[nodiscard]] JointVector acceleration_of(const JointVector& tau) const noexcept {
    return M_inverse_.lazyProduct(tau);
  }
  /// Jbar^T tau = Lambda J M^-1 tau: the wrench at the tool centre that joint torques `tau` stand
  /// for, weighted by inertia.
  [[nodiscard]] Vector6 wrench_of(const JointVector& tau) const noexcept;
  /// Jbar v = M^-1 J^T Lambda v: of the joint velocities that move the tool at `v` (where the cap
  /// lets it), those with the least kinetic energy.
  [[nodiscard]] JointVector joint_velocity_of(const Vector6& v) const noexcept;
  /// (I - J^T Jbar^T) tau: the part of `tau` that does not accelerate the tool.
  [[nodiscard]] JointVector null_space_part(const JointVector& tau) const noexcept;
  /// True where the cap is at work.
  [[nodiscard]] bool near_singularity() const noexcept { return near_singularity_; }

 private:
  JointMatrix M_inverse_ = JointMatrix::Identity();
  Matrix6 lambda_inverse_ = Matrix6::Identity();
  Matrix6 lambda_ = Matrix6::Identity();  ///< capped
  Jacobian J_ = Jacobian::Zero();
  bool near_singularity_ = false;
};

}  // namespace binpick
