#pragma once

#include <array>

#include "models/drive_description.h"
#include "models/robot.h"

namespace binpick {

/// The motor side of an arm with elastic joints, coupled to the links' simulation once per step.
///
/// Per joint (Spong's reduced model; Albu-Schaeffer, Ott and Hirzinger, IJRR 2007, eqs. 1-3):
///   B theta_dd = tau_m - tau_t - v theta_d - c sgn(theta_d),
///   tau_t = K (theta - q) + D (theta_d - qd).
/// One step of h is symplectic Euler on the springs, and implicit Euler on dampers, viscous and
/// Coulomb friction: tau_t holds theta - q of the step's beginning and the velocities of its end.
/// The links' end velocity is not known before their simulation has stepped. It enters linearly,
/// though, so that it can be handed over exactly: as an inertia that the link carries during the
/// step (`armature`) beside a torque. A motor sticks for a step if its friction can stop it, seen
/// from the link's velocity at the step's beginning.
///
/// Stable for h < 2 / omega with omega the fastest undamped joint mode: about 1200 rad/s at the
/// wrist with this repository's arm and gripper, hence h < 1.6 ms. Accuracy against finer steps:
/// tests/sim/elastic_drives_test.cpp.
class ElasticDrives {
 public:
  explicit ElasticDrives(const DriveDescription& drives) : drives_(drives) {}

  /// At rest, with the springs carrying `tau` between motors and links at `q`.
  void reset(const JointVector& q, const JointVector& tau);
  /// For the following steps, Nm.
  void set_motor_torques(const JointVector& tau) noexcept { tau_motor_ = tau; }

  /// What the links feel during a step.
  struct Coupling {
    JointVector torque = JointVector::Zero();    ///< Nm
    JointVector armature = JointVector::Zero();  ///< added to each link's own inertia, kg m^2
  };
  /// Begins a step of `h` seconds from link state (q, qd).
  [[nodiscard]] Coupling begin_step(const JointVector& q, const JointVector& qd, double h);
  /// Ends it, with the link state that the step has led to.
  void end_step(const JointVector& q, const JointVector& qd);

  [[nodiscard]] const JointVector& theta() const noexcept { return theta_; }      ///< rad
  [[nodiscard]] const JointVector& theta_d() const noexcept { return theta_d_; }  ///< rad/s
  /// What the torque sensors read, noise and offset apart: K (theta - q) through their bandwidth.
  [[nodiscard]] const JointVector& sensed_torque() const noexcept { return sensed_; }
  [[nodiscard]] const DriveDescription& description() const noexcept { return drives_; }

 private:
  /// theta_d at the step's end, as a function of the link's: base + share * qd.
  struct MotorStep {
    double base = 0.0;
    double share = 0.0;
  };

  DriveDescription drives_;
  JointVector theta_ = JointVector::Zero();
  JointVector theta_d_ = JointVector::Zero();
  JointVector sensed_ = JointVector::Zero();
  JointVector tau_motor_ = JointVector::Zero();
  double h_ = 0.0;
  std::array<MotorStep, kArmJoints> step_{};
};

}  // namespace binpick
