#pragma once

#include "control/arm_model.h"
#include "control/operational_space.h"

namespace binpick {

struct DisturbanceObserverOptions {
  /// K_O, 1/s: the estimate follows the truth with time constant 1/K_O. Higher is faster and
  /// noisier; 50 to 100.
  double gain = 50.0;

  /// @throws InputError if the gain is not positive.
  void validate() const;
};

/// Generalised-momentum disturbance observer (De Luca et al. 2006; Haddadin et al. 2008): with
/// p = M qd,
///   r = K_O [p - p(0) - int (tau + C^T qd - g + r) dt],   hence   dr/dt = K_O (tau_ext - r),
/// from link positions, link velocities and joint torque sensors: motor friction does not enter.
///
/// Discrete form. Over one period the integral's part without r is exactly
///   p_k - p_{k-1} - (M_k - M_{k-1}) (qd_k + qd_{k-1}) / 2 = (M_k + M_{k-1}) / 2 (qd_k - qd_{k-1})
/// plus dt (C qd + g - tau); the first-order filter on it is discretised exactly, so that the
/// time constant is 1/K_O at any period.
class DisturbanceObserver {
 public:
  explicit DisturbanceObserver(const DisturbanceObserverOptions& options);

  /// Starts anew at the next update, with a residual of zero. Call when the model changes (a
  /// payload is picked up or released).
  void reset() noexcept;

  /// Advances by `dt` seconds.
  /// @param tau joint torques, motors on links, during the period that ends at this state, Nm:
  ///   sensed, less the sensors' offsets, plus D (theta_d - qd) where joints are elastic.
  void update(const ArmDynamics& dynamics, const JointVector& qd, const JointVector& tau,
              double dt) noexcept;

  /// Estimated external joint torques, Nm; positive when they push the joint forward.
  [[nodiscard]] const JointVector& residual() const noexcept { return residual_; }
  /// External joint torques over the last period as the balance of momentum gives them, Nm: what
  /// the residual follows. Without its lag, but with all the noise.
  [[nodiscard]] const JointVector& unfiltered() const noexcept { return unfiltered_; }
  /// Estimated external wrench on the tool centre, world axes: Jbar^T r. Right when the arm is
  /// touched at the tool and away from singularities.
  [[nodiscard]] Vector6 external_wrench(const OperationalSpace& space) const noexcept {
    return space.wrench_of(residual());
  }
  [[nodiscard]] const DisturbanceObserverOptions& options() const noexcept { return options_; }

 private:
  DisturbanceObserverOptions options_;
  JointVector residual_ = JointVector::Zero();
  JointVector unfiltered_ = JointVector::Zero();
  // The state at the last update.
  bool started_ = false;
  JointMatrix M_ = JointMatrix::Zero();
  JointVector bias_ = JointVector::Zero();  ///< C qd + g
  JointVector qd_ = JointVector::Zero();
};

}  // namespace binpick
