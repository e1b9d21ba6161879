#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>

#include "control/arm_controller.h"
#include "control/cartesian_trajectory.h"
#include "control/collision_reaction.h"
#include "control/joint_trajectory.h"
#include "control/payload_estimator.h"
#include "models/robot.h"

namespace binpick {

/// How a motion ended.
enum class MotionEnd {
  kArrived,
  kContact,    ///< stopped on a contact that it was told to stop on
  kCollision,  ///< stopped by the collision reaction, once it had done what it does
  kLost,       ///< stopped because the watch on the gripper said so
};

/// What ends a motion before its end.
struct MotionStops {
  bool on_contact = false;
  bool on_collision = true;
  /// Asked after every tick; true ends the motion as kLost.
  std::function<bool(const GripperState&)> lost = nullptr;
};

/// Arm and gripper as one: drives a robot along trajectories and jaw motions through an
/// ArmController, one tick per control period. Every motion blocks until it ends, leaves the arm
/// holding its last set-point, and returns how it ended. Errors of the robot pass.
class Manipulator {
 public:
  /// `robot` must outlive the manipulator. The arm holds its pose at first.
  Manipulator(Robot& robot, const ArmModel& model, const ArmControllerOptions& options = {},
              const ReactionOptions& reaction = {});
  Manipulator(const Manipulator&) = delete;
  Manipulator& operator=(const Manipulator&) = delete;

  /// Joint impedance along `trajectory`, from its start.
  MotionEnd follow(const JointTrajectory& trajectory, const MotionStops& stops = {});
  /// Cartesian impedance along `trajectory`, from its start.
  MotionEnd follow(const CartesianTrajectory& trajectory, const MotionStops& stops = {});
  /// Cartesian impedance along a straight line from the present set-point (or pose) to `goal`.
  MotionEnd move_line(const Eigen::Isometry3d& T_world_goal, const CartesianMotionLimits& limits,
                      const MotionStops& stops = {});
  /// Holds the set-point for `duration` s.
  MotionEnd hold(double duration, const MotionStops& stops = {});

  /// Sets where the jaws go; they move along with the following motions.
  void command_gripper(const GripperCommand& command) noexcept { command_.gripper = command; }
  /// Moves the jaws while the arm holds, until they stand still. Returns the reading then.
  GripperState move_gripper(const GripperCommand& command);

  /// What the following motions are about: their thresholds, and the reaction selected for them.
  void enter(ContactPhase phase, const ContactThresholds& thresholds) noexcept;
  /// How motions of a phase react to collisions; kStop unless set.
  void set_reaction(ContactPhase phase, Reaction reaction) noexcept {
    reactions_[static_cast<std::size_t>(phase)] = reaction;
  }
  /// Off, collisions end no motion and change none.
  void enable_reaction(bool enabled) noexcept { reaction_enabled_ = enabled; }
  /// What collisions and contacts led to so far.
  [[nodiscard]] const CollisionReaction& reaction() const noexcept { return reaction_; }

  /// Takes the torque sensors' offsets from `duration` s of standstill. Nothing may be touched.
  /// @returns whether the arm stood still and the offsets were taken.
  bool calibrate_sensors(double duration = 0.5);
  /// Feels the weight in the jaws for `duration` s; nothing else may be touched.
  [[nodiscard]] BodyInertia weigh(double duration);
  /// By how much the load in the jaws is lighter than the controller's payload, kg; felt for
  /// `duration` s, nothing else may be touched.
  [[nodiscard]] double missing_weight(double duration);
  [[nodiscard]] ArmController& controller() noexcept { return controller_; }
  [[nodiscard]] const RobotState& state() const noexcept { return state_; }
  [[nodiscard]] RangeImage capture() { return robot_.capture(); }
  /// Largest magnitude of the estimated contact force since the last reset, N.
  [[nodiscard]] double peak_force() const noexcept { return peak_force_; }
  void reset_peak_force() noexcept { peak_force_ = 0.0; }

 private:
  /// Runs `set_target(t, rate)` and a tick for each period up to `duration`.
  template <class SetTarget>
  MotionEnd run(double duration, const MotionStops& stops, SetTarget set_target);
  void tick();
  [[nodiscard]] Eigen::Isometry3d line_start() const noexcept;

  Robot& robot_;
  ArmController controller_;
  RobotState state_;
  RobotCommand command_;
  CollisionReaction reaction_;
  std::array<Reaction, kContactPhases> reactions_;
  ContactPhase phase_ = ContactPhase::kFree;
  bool reaction_enabled_ = true;
  bool cartesian_ = false;  ///< the last set-point was Cartesian, and is T_set_point_
  Eigen::Isometry3d T_set_point_ = Eigen::Isometry3d::Identity();
  double peak_force_ = 0.0;
};

}  // namespace binpick
