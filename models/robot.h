#pragma once

#include <Eigen/Core>

#include "models/range_image.h"

namespace binpick {

inline constexpr int kArmJoints = 7;
using JointVector = Eigen::Matrix<double, kArmJoints, 1>;

/// What the arm's sensors say. Rigid joints report theta == q.
struct JointState {
  JointVector q = JointVector::Zero();      ///< link positions, rad
  JointVector qd = JointVector::Zero();     ///< link velocities, rad/s
  JointVector tau = JointVector::Zero();    ///< joint torque sensors, Nm, motor on link
  JointVector theta = JointVector::Zero();  ///< motor positions, rad
};

struct GripperState {
  double width = 0.0;  ///< distance between the pads, m
  double force = 0.0;  ///< force between the jaws, N
};

struct GripperCommand {
  double width = 0.0;   ///< wanted distance between the pads, m
  double speed = 0.1;   ///< of the distance, m/s
  double force = 40.0;  ///< limit, N
};

struct RobotState {
  JointState joints;
  GripperState gripper;
};

struct RobotCommand {
  JointVector tau = JointVector::Zero();  ///< joint torques, Nm, gravity included
  GripperCommand gripper;
};

/// The control period at the boundary, s.
inline constexpr double kControlPeriod = 0.001;

/// The boundary between the robot's brain and whatever it drives, simulated or real. Nothing else
/// passes: no simulator type, no ground truth, no simulated clock.
class Robot {
 public:
  virtual ~Robot() = default;

  [[nodiscard]] virtual RobotState state() const = 0;
  /// Sends `command`, lets one control period pass and returns the state after it.
  /// May throw when the robot fails (a diverged simulation, a spent time budget): the brain lets
  /// such errors pass.
  virtual RobotState exchange(const RobotCommand& command) = 0;
  /// Takes a range image. The arm keeps its last command meanwhile.
  [[nodiscard]] virtual RangeImage capture() = 0;
};

}  // namespace binpick
