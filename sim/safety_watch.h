#pragma once

#include <array>
#include <optional>
#include <string>

#include "models/robot_description.h"

namespace binpick {

/// What an arm's own safety electronics watch, independent of the brain: limits of command and
/// motion, and sensors that fail. Every finding is one line for a person.
class SafetyWatch {
 public:
  explicit SafetyWatch(const RobotDescription& arm);

  /// One control period: the torques that the brain commanded for it, the arm's true state at its
  /// end and what the sensors say of that state.
  /// * Commands stay within the joints' efforts and change by at most kTorqueRate.
  /// * Joints stay within their positions and speeds.
  /// * A reading that is not finite may last for kPatience: the brain sees it first, and shall
  ///   have brought the arm to rest before the brakes close.
  /// * Positions follow the integral of the velocities, and torques the commands, over kWindow:
  ///   a frozen sensor on a moving joint does not.
  [[nodiscard]] std::optional<std::string> check(const JointVector& tau, const JointState& truth,
                                                 const JointState& sensed);

  static constexpr double kTorqueRate = 1000.0;  ///< Nm/s; what comparable arms allow
  static constexpr double kPatience = 0.02;      ///< s
  static constexpr int kWindow = 50;             ///< control periods

 private:
  [[nodiscard]] std::optional<std::string> check_command(const JointVector& tau);
  [[nodiscard]] std::optional<std::string> check_motion(const JointState& truth) const;
  [[nodiscard]] std::optional<std::string> check_sensors(const JointVector& tau,
                                                         const JointState& sensed);

  std::array<JointDescription, kArmJoints> joints_;
  std::optional<JointVector> last_command_;
  int unreadable_periods_ = 0;
  int periods_ = 0;  ///< in the window
  JointVector window_start_ = JointVector::Zero();
  JointVector travelled_ = JointVector::Zero();        ///< integral of velocities, rad
  JointVector torque_mismatch_ = JointVector::Zero();  ///< smallest in the window, Nm
};

}  // namespace binpick
