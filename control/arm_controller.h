#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "control/arm_model.h"
#include "control/cartesian_impedance.h"
#include "control/contact_monitor.h"
#include "control/disturbance_observer.h"
#include "control/elastic_joints.h"
#include "control/joint_impedance.h"
#include "control/joint_limit_barrier.h"
#include "control/operational_space.h"
#include "control/torque_limiter.h"
#include "models/robot.h"

namespace binpick {

struct ArmControllerOptions {
  CartesianImpedanceOptions cartesian;
  JointImpedanceOptions joint;
  DisturbanceObserverOptions observer;
  TorqueLimiterOptions limiter;
  /// Set for an arm with elastic joints whose motors run a TorqueFeedback with the same numbers.
  std::optional<ElasticJoints> joints;
  double safe_stop_damping = 8.0;  ///< 1/s: braking torque per momentum after a fault
  /// Set-points that jump are approached at this speed, so that no spring is stretched at once.
  /// Above any planned speed.
  double max_target_speed = 1.2;  ///< m/s
  double max_target_turn = 3.0;   ///< rad/s, of the tool and of each joint
  /// Neither may such an approach ask any joint for more than this share of its speed limit.
  double max_target_joint_speed = 0.5;
  double floating_damping = 2.0;  ///< 1/s: torque per momentum while floating

  /// @throws InputError listing every value that makes no sense.
  void validate() const;
};

/// Which law drives the arm.
enum class ControlMode {
  kJoint,      ///< joint impedance towards the joint target
  kCartesian,  ///< Cartesian impedance towards the Cartesian target
  kFloating,   ///< gravity compensation and light damping: whoever pushes the arm, moves it
  kSafeStop,   ///< gravity compensation and braking, after a fault, until reset()
};

/// Why the arm was stopped safely.
enum class ControlFault {
  kNone,
  kBadState,   ///< a sensor delivered a value that is not finite
  kBadPeriod,  ///< dt was not a positive time of at most 0.1 s
  kBadTarget,  ///< the set-point led to torques that are not finite
};

/// What the controller knows after a tick.
struct ArmStatus {
  ControlMode mode = ControlMode::kJoint;
  ControlFault fault = ControlFault::kNone;
  JointVector q = JointVector::Zero();   ///< measured, rad
  JointVector qd = JointVector::Zero();  ///< measured, rad/s
  ArmDynamics dynamics;                  ///< at the measured state, payload included
  Eigen::Isometry3d T_world_tcp = Eigen::Isometry3d::Identity();  ///< measured
  Vector6 twist = Vector6::Zero();             ///< of the tool centre, world axes
  Vector6 external_wrench = Vector6::Zero();   ///< estimated, on the tool centre, world axes
  JointVector residual = JointVector::Zero();  ///< estimated external joint torques, Nm
  bool contact = false;                        ///< touching something, collisions included
  bool collision = false;                      ///< hf1 of Figs. 5 and 6
  Vector6 spring_wrench = Vector6::Zero();     ///< virtual spring at the tool centre, world axes
  double torque_share = 1.0;  ///< < 1: control torques were scaled down to the effort limits
};

/// The arm's controller at the boundary (joint state, dt) -> joint torques: observer, contact
/// monitor, joint and Cartesian impedance, limits. With elastic joints the laws act on the motors:
/// at qb, the static equivalent of the motor positions, where K (theta - qb) = l(qb) with all that
/// a law asks for at rest, and at the motor velocities, with M + B_theta (Ott 2008, chapter 5;
/// Albu-Schaeffer et al. 2007). At rest q = qb, whatever pulls: the stiffness is exact, and
/// feedback and actuation stay collocated, hence passive. Observer and monitor live on the links. A
/// motion layer gives a set-point before each tick and reads the status after it:
///
///   controller.set_cartesian_target(line.sample(t));
///   command.tau = controller.tick(state.joints, kControlPeriod);
///   if (controller.status().collision) controller.stop();
///
/// The first tick holds the measured pose unless a target was given. When the kind of target
/// changes, the new law's equilibrium starts at the measured state and moves to the target from
/// there; trajectories that begin at the measured state are followed at once.
///
/// Not thread-safe. The tick and the setters allocate nothing, except set_payload.
class ArmController {
 public:
  /// @throws InputError if the options make no sense.
  explicit ArmController(const ArmModel& model, const ArmControllerOptions& options = {});

  void set_joint_target(const JointTarget& target) noexcept;
  void set_cartesian_target(const CartesianTarget& target) noexcept;
  /// Of the Cartesian law, tool axes, N/m and Nm/rad; comes into force along the ramp.
  void set_stiffness(const Vector6& stiffness) noexcept;
  /// Where the Cartesian law's null space pulls the arm, rad. Without a call: the posture in which
  /// the Cartesian law took over.
  void set_posture(const JointVector& q) noexcept;
  void set_thresholds(const ContactThresholds& thresholds) noexcept;

  /// The stop reaction: the equilibrium becomes the present pose, at rest, so that the stored
  /// spring is gone; the given set-points are abandoned. Keeps the mode.
  void stop() noexcept;
  /// The springs start anew from the present pose; the targets stay.
  void cancel_spring() noexcept { starting_ = true; }
  /// The gravity-compensated torque mode: until a target is given or the arm is stopped, it yields
  /// to every push.
  void float_freely() noexcept;

  /// Tells the model what the gripper carries (tool-centre frame); the observer starts anew.
  /// @throws InputError for a negative mass.
  void set_payload(const BodyInertia& payload);
  void clear_payload() noexcept;
  /// What the torque sensors read too much, Nm; subtracted from now on. The observer starts anew.
  void set_sensor_offset(const JointVector& offset) noexcept;
  [[nodiscard]] const JointVector& sensor_offset() const noexcept { return sensor_offset_; }
  /// Takes the present residual as one more sensor offset. Only at rest and out of contact.
  void zero_observer() noexcept;

  /// One control period: torques for the motors, gravity included, always finite and within the
  /// limits.
  [[nodiscard]] JointVector tick(const JointState& state, double dt) noexcept;

  [[nodiscard]] const ArmStatus& status() const noexcept { return status_; }
  /// Stiffness in force, tool axes.
  [[nodiscard]] const Vector6& stiffness() const noexcept { return cartesian_.stiffness(); }
  /// With the payload.
  [[nodiscard]] const ArmModel& model() const noexcept { return model_; }

  /// Ends a safe stop: holds the pose of the next tick.
  void reset() noexcept;

 private:
  void enter(ControlMode mode) noexcept;
  void restart_observer() noexcept;
  void hold_present_pose() noexcept;
  void start_law() noexcept;
  /// Moves the equilibrium towards the target, as fast as a set-point may move.
  void approach_target(double dt) noexcept;
  void approach_joint_target(double dt) noexcept;
  void approach_cartesian_target(double dt) noexcept;
  void sense(const JointState& state, double dt) noexcept;
  /// Elastic joints: the static equivalent of the motor positions, and the dynamics there.
  void sense_motors(const JointState& state) noexcept;
  /// Gravity and what the law in force asks for at rest, where it acts.
  [[nodiscard]] JointVector static_torques() const noexcept;
  [[nodiscard]] JointVector control_torques(double dt) noexcept;
  /// `tau` without what would drive a joint beyond its speed limit or into its position limit.
  [[nodiscard]] JointVector within_joint_limits(const JointVector& tau, double dt) const noexcept;
  /// Enters the safe stop; the first fault is remembered.
  void raise(ControlFault fault) noexcept;
  /// Gravity compensation and a brake against `qd`.
  [[nodiscard]] JointVector safe_stop(const JointVector& qd, double dt) noexcept;
  /// What the laws act on: the links, or elastic joints' motors.
  [[nodiscard]] const ArmDynamics& dynamics() const noexcept {
    return options_.joints ? motors_.dynamics : status_.dynamics;
  }
  [[nodiscard]] const OperationalSpace& space() const noexcept {
    return options_.joints ? motors_.space : space_;
  }
  [[nodiscard]] const JointVector& q() const noexcept {
    return options_.joints ? motors_.q : status_.q;
  }
  [[nodiscard]] const JointVector& qd() const noexcept {
    return options_.joints ? motors_.qd : status_.qd;
  }

  ArmControllerOptions options_;
  ArmModel unloaded_model_;
  ArmModel model_;
  CartesianImpedance cartesian_;
  JointImpedance joint_;
  DisturbanceObserver observer_;
  ContactMonitor monitor_;
  TorqueLimiter limiter_;
  JointLimitBarrier barrier_;

  ControlMode mode_ = ControlMode::kJoint;
  bool hold_ = true;      ///< the next tick takes the measured pose as its target
  bool starting_ = true;  ///< the law of `mode_` has not run yet
  JointTarget joint_target_;
  CartesianTarget cartesian_target_;
  // Where the springs pull now; the targets, except after a jump.
  JointVector q_equilibrium_ = JointVector::Zero();
  Eigen::Isometry3d T_world_equilibrium_ = Eigen::Isometry3d::Identity();
  std::optional<JointVector> posture_;
  JointVector sensor_offset_ = JointVector::Zero();
  OperationalSpace space_;
  /// Elastic joints, seen from the motors.
  struct {
    JointVector q = JointVector::Zero();     ///< qb, static equivalent of the motor positions
    JointVector qd = JointVector::Zero();    ///< motor velocities
    JointVector load = JointVector::Zero();  ///< l(qb)
    ArmDynamics dynamics;                    ///< at qb, M with the shaped motor inertia
    OperationalSpace space;
    bool known = false;  ///< since the start, or since the model changed
  } motors_;
  ArmStatus status_;
};

}  // namespace binpick
