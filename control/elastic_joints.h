#pragma once

#include "control/operational_space.h"
#include "models/drive_description.h"
#include "models/robot.h"

namespace binpick {

/// What the control laws know about elastic joints,
///   M(q) qdd + C qd + g(q) = tau + D K^-1 tau_d + tau_ext,
///   B theta_dd + tau + D K^-1 tau_d = tau_m - tau_f,   tau = K (theta - q).
struct ElasticJoints {
  JointVector stiffness = JointVector::Zero();      ///< K, Nm/rad
  JointVector damping = JointVector::Zero();        ///< D, Nm s/rad
  JointVector motor_inertia = JointVector::Zero();  ///< B, kg m^2, on the link side of the gear
  /// B / B_theta: how many times lighter torque feedback makes the motors feel. 4 to 6 are usual.
  double inertia_reduction = 4.0;
  /// With the motors on top the tool shows more inertia than that of the links alone: in place of
  /// the Cartesian law's cap.
  InertiaCap inertia_cap{.mass = 100.0, .inertia = 20.0};

  [[nodiscard]] static ElasticJoints of(const DriveDescription& drives) noexcept;
  /// B_theta: what is left of the motor inertia under torque feedback, kg m^2.
  [[nodiscard]] JointVector shaped_inertia() const noexcept {
    return motor_inertia / inertia_reduction;
  }
  /// @throws InputError listing every value that makes no sense.
  void validate() const;
};

/// The inner torque loop of elastic joints (Ott 2008, section 4.2; Albu-Schaeffer et al. 2007,
/// eq. 13):
///   tau_m = B B_theta^-1 u + (1 - B B_theta^-1) (tau + D K^-1 tau_d).
/// Seen from the outer law, which asks for the joint torques u, the motors have the inertia
/// B_theta, and their friction is B_theta B^-1 as large. D K^-1 tau_d = D (theta_d - qd) is taken
/// from the velocities; the torque signal is never differentiated.
///
///   robot.set_torque_loop(torque_feedback.loop());
class TorqueFeedback {
 public:
  /// @throws InputError if the joints make no sense.
  explicit TorqueFeedback(const ElasticJoints& joints);

  /// Motor torques for wanted joint torques `u`, Nm. Allocates nothing.
  [[nodiscard]] JointVector motor_torques(const JointState& state,
                                          const JointVector& u) const noexcept;
  /// What the torque sensors read at no load, Nm; subtracted.
  void set_sensor_offset(const JointVector& offset) noexcept { sensor_offset_ = offset; }

  /// The same for a drive to call. Refers to this object, which must outlive it.
  [[nodiscard]] JointTorqueLoop loop() const;

 private:
  double reduction_;
  JointVector damping_;
  JointVector sensor_offset_ = JointVector::Zero();
};

}  // namespace binpick
