#include "control/manipulator.h"

#include <algorithm>
#include <cmath>

#include "control/sensor_calibration.h"

namespace binpick {
namespace {

// Jaws stand still when they have moved less than this within the watch time.
constexpr double kJawStandstill = 0.0002;
constexpr double kJawWatchTime = 0.1;
// Backstop, 5 s: longer than the slowest full stroke at 50 mm/s.
constexpr int kMostJawWatches = 50;

}  // namespace

Manipulator::Manipulator(Robot& robot, const ArmModel& model, const ArmControllerOptions& options,
                         const ReactionOptions& reaction)
    : robot_(robot),
      controller_(model, options),
      state_(robot.state()),
      reaction_(controller_, reaction) {
  command_.gripper.width = state_.gripper.width;
  reactions_.fill(Reaction::kStop);
}

void Manipulator::enter(ContactPhase phase, const ContactThresholds& thresholds) noexcept {
  phase_ = phase;
  controller_.set_thresholds(thresholds);
}

void Manipulator::tick() {
  command_.tau = controller_.tick(state_.joints, kControlPeriod);
  state_ = robot_.exchange(command_);
  peak_force_ = std::max(peak_force_, controller_.status().external_wrench.head<3>().norm());
}

template <class SetTarget>
MotionEnd Manipulator::run(double duration, const MotionStops& stops, SetTarget set_target) {
  const bool reacts = reaction_enabled_ && stops.on_collision;
  reaction_.begin(reacts ? reactions_[static_cast<std::size_t>(phase_)] : Reaction::kNone);
  const double ticks = std::ceil(duration / kControlPeriod);
  double delay = 0.0;  // ticks by which the time along the path is behind the clock
  for (long i = 1; reaction_.drives() || static_cast<double>(i - 1) - delay < ticks; ++i) {
    const double rate = reaction_.path_rate();
    delay += 1.0 - rate;
    const double t = (static_cast<double>(i) - delay) * kControlPeriod;
    if (!reaction_.drives()) set_target(std::clamp(t, 0.0, duration), rate);
    tick();
    reaction_.update(kControlPeriod);
    const bool touched = stops.on_contact && controller_.status().contact;
    const bool lost = stops.lost && stops.lost(state_.gripper);
    if (reaction_.stopped() || touched || lost) {
      controller_.stop();
      cartesian_ = false;
      return reaction_.stopped() ? MotionEnd::kCollision
             : touched           ? MotionEnd::kContact
                                 : MotionEnd::kLost;
    }
  }
  return MotionEnd::kArrived;
}

MotionEnd Manipulator::follow(const JointTrajectory& trajectory, const MotionStops& stops) {
  cartesian_ = false;
  return run(trajectory.duration(), stops, [&](double t, double rate) {
    JointTarget target = trajectory.sample(t);
    target.qd *= rate;
    target.qdd *= rate * rate;
    controller_.set_joint_target(target);
  });
}

MotionEnd Manipulator::follow(const CartesianTrajectory& trajectory, const MotionStops& stops) {
  cartesian_ = true;
  T_set_point_ = trajectory.goal();
  return run(trajectory.duration(), stops, [&](double t, double rate) {
    CartesianTarget target = trajectory.sample(t);
    target.twist *= rate;
    target.acceleration *= rate * rate;
    controller_.set_cartesian_target(target);
  });
}

MotionEnd Manipulator::move_line(const Eigen::Isometry3d& T_world_goal,
                                 const CartesianMotionLimits& limits, const MotionStops& stops) {
  return follow(CartesianTrajectory(line_start(), T_world_goal, limits), stops);
}

MotionEnd Manipulator::hold(double duration, const MotionStops& stops) {
  return run(duration, stops, [](double, double) {});
}

Eigen::Isometry3d Manipulator::line_start() const noexcept {
  // A line that goes on from a Cartesian set-point continues its spring; any other starts at rest.
  return cartesian_ ? T_set_point_ : controller_.model().forward_kinematics(state_.joints.q);
}

bool Manipulator::calibrate_sensors(double duration) {
  SensorCalibration calibration;
  for (double t = 0.0; t < duration; t += kControlPeriod) {
    tick();
    calibration.add(state_.joints.tau, controller_.status().dynamics.gravity, state_.joints.qd);
  }
  const std::optional<JointVector> offset = calibration.offset();
  if (offset) controller_.set_sensor_offset(*offset);
  return offset.has_value();
}

BodyInertia Manipulator::weigh(double duration) {
  PayloadEstimator estimator;
  for (double t = 0.0; t < duration; t += kControlPeriod) {
    tick();
    const ArmStatus& status = controller_.status();
    estimator.add(status.external_wrench, status.T_world_tcp);
  }
  return estimator.estimate();
}

double Manipulator::missing_weight(double duration) {
  constexpr double kGravity = 9.81;
  double lift = 0.0;
  int ticks = 0;
  for (double t = 0.0; t < duration; t += kControlPeriod, ++ticks) {
    tick();
    lift += controller_.status().external_wrench[2];
  }
  return ticks == 0 ? 0.0 : lift / (ticks * kGravity);
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
