#pragma once

#include <cstdint>
#include <functional>
#include <limits>

#include "models/random.h"
#include "models/robot.h"
#include "sim/depth_camera.h"
#include "sim/world.h"

namespace binpick {

/// Imperfections of the arm's sensors.
struct SensorNoise {
  double torque_sigma = 0.0;   ///< white noise of each joint torque sensor, Nm
  double torque_offset = 0.0;  ///< offsets drawn once, uniform in +- this, Nm
};

struct SimulatedRobotOptions {
  StructuredLightOptions camera_noise;
  SensorNoise sensor_noise;
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
  /// @throws SimulationDiverged, TimeBudgetSpent, std::invalid_argument for a command that is not
  /// finite.
  RobotState exchange(const RobotCommand& command) override;
  /// The world stands still while the image is taken.
  [[nodiscard]] RangeImage capture() override;

  [[nodiscard]] std::uint64_t frames_taken() const noexcept { return frames_; }

 private:
  void read_sensors();

  World& world_;
  DepthCamera* camera_;
  SimulatedRobotOptions options_;
  JointVector torque_offset_ = JointVector::Zero();
  Random torque_noise_;
  double end_time_;
  std::uint64_t frames_ = 0;
  RobotState state_;
};

}  // namespace binpick
