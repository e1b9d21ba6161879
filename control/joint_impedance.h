#pragma once

#include "control/arm_model.h"
#include "control/damping_design.h"
#include "control/motion_target.h"

namespace binpick {

struct JointImpedanceOptions {
  /// Nm/rad.
  JointVector stiffness = (JointVector() << 1500, 1500, 1000, 1000, 600, 300, 300).finished();
  double damping_ratio = 0.7;  ///< of every mode
  /// No spring pulls harder than this share of its joint's effort limit.
  double max_spring_share = 0.3;

  /// @throws InputError listing every value that makes no sense.
  void validate() const;
};

/// Joint impedance: tau = M qdd_d + alpha C qd + sat(K (q_d - q)) + D (qd_d - qd), without gravity,
/// which the caller adds; D from K and M by double diagonalisation. alpha in [0, 1] is the share
/// of the present velocity that the target asks for (see CartesianImpedance).
class JointImpedance {
 public:
  JointImpedance(const JointLimits& limits, const JointImpedanceOptions& options);

  /// Joint torques without gravity, Nm. Allocates nothing.
  [[nodiscard]] JointVector torques(const ArmDynamics& dynamics, const JointVector& q,
                                    const JointVector& qd, const JointTarget& target) noexcept;
  /// The part of the law that depends on positions alone, Nm: the spring.
  [[nodiscard]] JointVector static_torques(const JointVector& q,
                                           const JointVector& q_target) const noexcept {
    return options_.stiffness.cwiseProduct(q_target - q)
        .cwiseMax(-max_spring_torque_)
        .cwiseMin(max_spring_torque_);
  }
  /// Forgets the last call.
  void reset() noexcept { damping_design_.reset(); }

  [[nodiscard]] const JointImpedanceOptions& options() const noexcept { return options_; }

 private:
  JointImpedanceOptions options_;
  JointVector max_spring_torque_;
  DampingDesign<kArmJoints> damping_design_;
};

}  // namespace binpick
