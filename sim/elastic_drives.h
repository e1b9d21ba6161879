#pragma once

#include <array>
#include <functional>

#include "models/drive_description.h"
#include "models/robot.h"

namespace binpick {

/// The motor side of an arm with elastic joints, coupled to the links' simulation once per step.
///
/// Per joint (Spong's reduced model; Albu-Schaeffer, Ott and Hirzinger, IJRR 2007, eqs. 1-3):
///   B theta_dd = tau_m - tau_t - v theta_d - c sgn(theta_d),
///   tau_t = K (theta - q) + D (theta_d - qd).
/// The links take long steps H, since contacts make theirs dear; motors and their torque loop take
/// several short ones inside. The links' step is a leapfrog: a velocity belongs to the middle
/// between two positions. What pushes the link from one velocity to the next is therefore tau_t's
/// mean from H/2 before the step's position to H/2 after it, and that is where the motors are moved
/// along: with q = q_0 + qd_0 t before the position and q_0 + qd_1 t after it, qd_1 being the
/// velocity that the step will lead to. Everything is symmetric in time, so that the springs are
/// neither damped nor driven by the steps. The short steps are leapfrogs too, with dampers, viscous
/// and Coulomb friction in implicit Euler.
///
/// qd_1 is not known before the links' simulation has stepped. It enters linearly, though, so that
/// it can be handed over exactly: as an inertia that the link carries during the step (`armature`)
/// beside a torque. Only what sticks and what the torque loop is shown take qd_0 for it.
///
/// Stable for H < 2.8 / omega with omega the fastest undamped joint mode: about 1200 rad/s at the
/// wrist with this repository's arm and gripper, hence H < 2.3 ms. Accuracy against finer steps:
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
  using TorqueLoop = std::function<JointVector(const JointState&)>;
  /// Begins a step of `duration` seconds from link state (q, qd), of as many short steps as given.
  /// Before each of them `loop`, unless it is empty, says the motors' torques.
  [[nodiscard]] Coupling begin_step(const JointVector& q, const JointVector& qd, double duration,
                                    int short_steps = 1, const TorqueLoop& loop = {});
  /// Ends it, with the link velocity that the step has led to.
  void end_step(const JointVector& qd);

  /// Motor positions, brought forward to the time of the links' positions, rad.
  [[nodiscard]] JointVector theta() const noexcept { return theta_ + lead_ * theta_d_; }
  [[nodiscard]] const JointVector& theta_d() const noexcept { return theta_d_; }  ///< rad/s
  /// What the torque sensors read, noise and offset apart: K (theta - q) through their bandwidth.
  [[nodiscard]] const JointVector& sensed_torque() const noexcept { return sensed_; }
  [[nodiscard]] const DriveDescription& description() const noexcept { return drives_; }

 private:
  /// A quantity as a function of the velocity to which the step will lead the link.
  struct Line {
    double base = 0.0;
    double slope = 0.0;

    [[nodiscard]] double at(double qd) const noexcept { return base + slope * qd; }
  };
  /// One joint within a step.
  struct Motor {
    Line theta;
    Line theta_d;
    Line sensed;
    Line impulse;  ///< that the link has got so far, Nm s
  };

  /// One short step of `h` seconds, from `time` seconds after the links' position `q`.
  void advance(Motor& motor, int joint, double q, double qd, double time, double h) const noexcept;

  DriveDescription drives_;
  JointVector theta_ = JointVector::Zero();
  JointVector theta_d_ = JointVector::Zero();
  JointVector sensed_ = JointVector::Zero();
  JointVector tau_motor_ = JointVector::Zero();
  double lead_ = 0.0;  ///< time of the links' positions less that of theta_, s
  std::array<Motor, kArmJoints> motors_{};
};

}  // namespace binpick
