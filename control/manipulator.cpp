#include "control/manipulator.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

// Jaws stand still when they have moved less than this within the watch time.
constexpr double kJawStandstill = 0.0002;
constexpr double kJawWatchTime = 0.1;
// Backstop, 5 s: longer than the slowest full stroke at 50 mm/s.
constexpr int kMostJawWatches = 50;

}  // namespace

Manipulator::Manipulator(Robot& robot, const ArmModel& model, const ArmControllerOptions& options)
    : robot_(robot), controller_(model, options), state_(robot.state()) {
  command_.gripper.width = state_.gripper.width;
}

void Manipulator::tick() {
  command_.tau = controller_.tick(state_.joints, kControlPeriod);
  state_ = robot_.exchange(command_);
  peak_force_ = std::max(peak_force_, controller_.status().external_wrench.head<3>().norm());
}

template <class SetTarget>
MotionEnd Manipulator::run(double duration, const MotionStops& stops, SetTarget set_target) {
  const auto ticks = static_cast<long>(std::ceil(duration / kControlPeriod));
  for (long i = 1; i <= ticks; ++i) {
    set_target(std::min(static_cast<double>(i) * kControlPeriod, duration));
    tick();
    const ArmStatus& status = controller_.status();
    const bool collided = reaction_ && stops.on_collision && status.collision;
    const bool touched = stops.on_contact && status.contact;
    const bool lost = stops.lost && stops.lost(state_.gripper);
    if (collided || touched || lost) {
      controller_.stop();
      cartesian_ = false;
      return collided ? MotionEnd::kCollision : touched ? MotionEnd::kContact : MotionEnd::kLost;
    }
  }
  return MotionEnd::kArrived;
}

MotionEnd Manipulator::follow(const JointTrajectory& trajectory, const MotionStops& stops) {
  cartesian_ = false;
  return run(trajectory.duration(), stops,
             [&](double t) { controller_.set_joint_target(trajectory.sample(t)); });
}

MotionEnd Manipulator::follow(const CartesianTrajectory& trajectory, const MotionStops& stops) {
  cartesian_ = true;
  T_set_point_ = trajectory.goal();
  return run(trajectory.duration(), stops,
             [&](double t) { controller_.set_cartesian_target(trajectory.sample(t)); });
}

MotionEnd Manipulator::move_line(const Eigen::Isometry3d& T_world_goal,
                                 const CartesianMotionLimits& limits, const MotionStops& stops) {
  return follow(CartesianTrajectory(line_start(), T_world_goal, limits), stops);
}

MotionEnd Manipulator::hold(double duration, const MotionStops& stops) {
  return run(duration, stops, [](double) {});
}

Eigen::Isometry3d Manipulator::line_start() const noexcept {
  // A line that goes on from a Cartesian set-point continues its spring; any other starts at rest.
  return cartesian_ ? T_set_point_ : controller_.model().forward_kinematics(state_.joints.q);
}

GripperState Manipulator::move_gripper(const GripperCommand& command) {
  command_gripper(command);
  for (int watch = 0; watch < kMostJawWatches; ++watch) {
    const double before = state_.gripper.width;
    hold(kJawWatchTime, {.on_collision = false});
    if (std::abs(state_.gripper.width - before) < kJawStandstill) break;
  }
  return state_.gripper;
}

}  // namespace binpick
