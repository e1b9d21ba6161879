#pragma once

#include <Eigen/Core>
#include <functional>

#include "models/range_image.h"

namespace binpick {

inline constexpr int kArmJoints = 7;
using JointVector = Eigen::Matrix<double, kArmJoints, 1>;

/// What the arm's sensors say. Motor quantities are reflected to the link side of the gears. Rigid
/// joints report theta == q and theta_d == qd; elastic ones tau = K (theta - q), as the strain
/// gauges between gear and link read it: bandwidth, offset and noise included.
struct JointState {
  JointVector q = JointVector::Zero();        ///< link positions, rad
  JointVector qd = JointVector::Zero();       ///< link velocities, rad/s
  JointVector tau = JointVector::Zero();      ///< joint torque sensors, Nm, motor on link
  JointVector theta = JointVector::Zero();    ///< motor positions, rad
  JointVector theta_d = JointVector::Zero();  ///< motor velocities, rad/s
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
  /// Wanted joint torques, Nm, gravity included: what the torque loop tracks; without one, the
  /// motors' torques.
  JointVector tau = JointVector::Zero();
  GripperCommand gripper;
};

/// The control period at the boundary, s.
inline constexpr double kControlPeriod = 0.001;
/// Periods of the drives' torque loop per control period: 3 kHz, as in the LWR-III.
inline constexpr int kTorqueLoopsPerControl = 3;

/// The torque loop of elastic joints: (sensors, wanted joint torques tau, dt) -> motor torques.
/// It belongs to the brain but runs inside the drives, kTorqueLoopsPerControl times per control
/// period. Must be noexcept in effect, allocate nothing and return finite torques for finite input.
/// An arm with rigid joints needs none: its motors put tau on the links at once.
using JointTorqueLoop =
    std::function<JointVector(const JointState& state, const JointVector& tau, double dt)>;

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
