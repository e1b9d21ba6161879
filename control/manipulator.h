#pragma once

#include <Eigen/Geometry>
#include <functional>

#include "control/arm_controller.h"
#include "control/cartesian_trajectory.h"
#include "control/joint_trajectory.h"
#include "models/robot.h"

namespace binpick {

/// How a motion ended.
enum class MotionEnd {
  kArrived,
  kContact,    ///< stopped on a contact that it was told to stop on
  kCollision,  ///< stopped by the collision reaction
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
  Manipulator(Robot& robot, const ArmModel& model, const ArmControllerOptions& options = {});

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

  /// Without effect while the collision reaction is off: collisions end no motion.
  void enable_reaction(bool enabled) noexcept { reaction_ = enabled; }
  [[nodiscard]] ArmController& controller() noexcept { return controller_; }
  [[nodiscard]] const RobotState& state() const noexcept { return state_; }
  [[nodiscard]] RangeImage capture() { return robot_.capture(); }
  /// Largest magnitude of the estimated contact force since the last reset, N.
  [[nodiscard]] double peak_force() const noexcept { return peak_force_; }
  void reset_peak_force() noexcept { peak_force_ = 0.0; }

 private:
  /// Runs `set_target(t)` and a tick for each period up to `duration`.
  template <class SetTarget>
  MotionEnd run(double duration, const MotionStops& stops, SetTarget set_target);
  void tick();
  [[nodiscard]] Eigen::Isometry3d line_start() const noexcept;

  Robot& robot_;
  ArmController controller_;
  RobotState state_;
  RobotCommand command_;
  bool reaction_ = true;
  bool cartesian_ = false;  ///< the last set-point was Cartesian, and is T_set_point_
  Eigen::Isometry3d T_set_point_ = Eigen::Isometry3d::Identity();
  double peak_force_ = 0.0;
};

}  // namespace binpick
