#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>

#include "models/random.h"
#include "models/robot.h"
#include "sim/depth_camera.h"
#include "sim/safety_watch.h"
#include "sim/world.h"

namespace binpick {

/// Imperfections of the arm's sensors.
struct SensorNoise {
  double torque_sigma = 0.0;     ///< white noise of each joint torque sensor, Nm
  double torque_offset = 0.0;    ///< of each, drawn once, uniform in +- this, Nm
  double position_offset = 0.0;  ///< of each joint's zero, drawn once, uniform in +- this, rad
};

/// A joint sensor that fails during a trial.
struct SensorFault {
  enum class Kind {
    kPositionNan,  ///< link and motor position read NaN
    kTorqueNan,    ///< the torque reads NaN
    kFrozen,       ///< all of the joint's readings stay what they were
  };
  Kind kind = Kind::kFrozen;
  int joint = 0;
  double start = 0.0;  ///< world time, s; never heals
};

struct SimulatedRobotOptions {
  StructuredLightOptions camera_noise;
  SensorNoise sensor_noise;
  double jaw_offset = 0.0;  ///< the jaws stand this much further apart than they read, m
  /// Of elastic joints; runs in the drives, on sensors without latency. Empty: motors put out the
  /// command. Should it return a torque that is not finite, the drives fall back to the command.
  JointTorqueLoop torque_loop;
  int latency = 0;  ///< control periods by which states reach the brain late
  std::optional<SensorFault> fault;
  /// Whether the arm's safety watches over limits and sensors, and closes the brakes.
  bool watched = true;
  double time_budget = std::numeric_limits<double>::infinity();  ///< simulated, from here on, s
  Seed seed = 0;                                                 ///< of the sensors' noise
  /// Called after every step: recording, the referee's watch.
  std::function<void(World&)> on_step;
};

/// The robot that the brain drives, on a simulated world.
class SimulatedRobot final : public Robot {
 public:
  /// `camera` may be null for a robot that never looks. Both must outlive the robot.
  /// Releases the arm from its hold.
  SimulatedRobot(World& world, DepthCamera* camera, SimulatedRobotOptions options);

  [[nodiscard]] RobotState state() const override { return state_; }
  /// @throws SimulationDiverged, TimeBudgetSpent, RobotStopped (the arm is held by its brakes
  /// then), std::invalid_argument for a command that is not finite.
  RobotState exchange(const RobotCommand& command) override;
  /// The world stands still while the image is taken.
  [[nodiscard]] RangeImage capture() override;

  SimulatedRobot(const SimulatedRobot&) = delete;
  SimulatedRobot& operator=(const SimulatedRobot&) = delete;
  ~SimulatedRobot() override;

  [[nodiscard]] std::uint64_t frames_taken() const noexcept { return frames_; }

 private:
  [[nodiscard]] JointState measured(const JointState& truth);
  [[nodiscard]] JointVector motor_torques(const JointState& truth);
  void read_sensors();
  void watch_over(const JointVector& tau);

  World& world_;
  DepthCamera* camera_;
  SimulatedRobotOptions options_;
  JointVector torque_offset_;
  JointVector position_offset_;
  Random torque_noise_;
  std::optional<JointState> before_fault_;
  SafetyWatch watch_;
  JointVector command_ = JointVector::Zero();
  double end_time_;
  std::uint64_t frames_ = 0;
  std::deque<RobotState> in_flight_;  ///< read, but not yet with the brain
  RobotState state_;
};

}  // namespace binpick
