#pragma once

#include "models/gripper_description.h"
#include "models/robot.h"

namespace binpick {

/// The gripper's own controller: a set-point that moves to the commanded width at the commanded
/// speed, a stiff position servo that follows it, and a force limit. One step per millisecond.
class GripperServo {
 public:
  GripperServo() = default;
  explicit GripperServo(const GripperDescription& gripper)
      : stroke_(gripper.stroke), speed_(gripper.speed), max_force_(gripper.max_force) {}

  void set_command(const GripperCommand& command);
  /// Puts the set-point at `width`, at rest.
  void reset(double width);
  /// The drive's force on each jaw, opening positive, for jaws at `width` opening with `rate`. N
  [[nodiscard]] double update(double width, double rate, double dt);
  /// Closing force of the last update, N.
  [[nodiscard]] double closing_force() const noexcept { return -force_; }

 private:
  Interval stroke_;
  Interval speed_;
  double max_force_ = 0.0;
  GripperCommand command_;
  double set_point_ = 0.0;
  double force_ = 0.0;
};

}  // namespace binpick
