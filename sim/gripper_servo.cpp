#include "sim/gripper_servo.h"

#include <algorithm>

namespace binpick {
namespace {

// A stiff industrial servo: 40 N at 2 mm of lag. The damping is near critical for the half kilogram
// of reflected inertia per jaw (mjcf_writer.cpp) and far below the stability limit of 1 ms steps.
constexpr double kStiffness = 20000.0;  // N/m of pad distance
constexpr double kDamping = 150.0;      // N s/m

}  // namespace

void GripperServo::set_command(const GripperCommand& command) { command_ = command; }

void GripperServo::reset(double width) {
  set_point_ = width;
  command_.width = width;
  force_ = 0.0;
}

double GripperServo::update(double width, double rate, double dt) {
  const double limit = std::clamp(command_.force, 0.0, max_force_);
  const double target = std::clamp(command_.width, stroke_.low, stroke_.high);
  const double speed = std::clamp(command_.speed, speed_.low, speed_.high);
  const double step = std::clamp(target - set_point_, -speed * dt, speed * dt);
  set_point_ += step;
  // A blocked jaw holds the set-point back where the force limit is reached, so that it neither
  // winds up nor jumps when the way is free again.
  const double reach = limit / kStiffness;
  set_point_ = std::clamp(set_point_, width - reach, width + reach);
  force_ =
      std::clamp(kStiffness * (set_point_ - width) + kDamping * (step / dt - rate), -limit, limit);
  return force_;
}

}  // namespace binpick
