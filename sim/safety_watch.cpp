#include "sim/safety_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr double kRounding = 1e-9;
constexpr double kPositionMismatch = 0.01;  // rad per window
// Of a joint's effort: friction and motor inertia of elastic joints keep sensed torques from the
// commanded ones by less.
constexpr double kTorqueMismatch = 0.25;

std::optional<std::string> beyond(int joint, const char* what, double value, const char* relation,
                                  double limit, const char* unit) {
  return fmt::format("joint {}: {} {:.4g} {} {:.4g} {}", joint + 1, what, value, relation, limit,
                     unit);
}

}  // namespace

SafetyWatch::SafetyWatch(const RobotDescription& arm) : joints_(arm.joints) {}

std::optional<std::string> SafetyWatch::check(const JointVector& tau, const JointState& truth,
                                              const JointState& sensed) {
  auto finding = check_command(tau);
  if (!finding) finding = check_motion(truth);
  if (!finding) finding = check_sensors(tau, sensed);
  return finding;
}

std::optional<std::string> SafetyWatch::check_command(const JointVector& tau) {
  const JointVector before = last_command_.value_or(tau);
  last_command_ = tau;
  for (int i = 0; i < kArmJoints; ++i) {
    const double effort = joints_[std::size_t(i)].effort;
    if (std::abs(tau[i]) > effort + kRounding) {
      return beyond(i, "commanded torque", tau[i], "exceeds", effort, "Nm");
    }
    const double rate = std::abs(tau[i] - before[i]) / kControlPeriod;
    if (rate > kTorqueRate * (1.0 + kRounding)) {
      return beyond(i, "commanded torque rate", rate, "exceeds", kTorqueRate, "Nm/s");
    }
  }
  return std::nullopt;
}

std::optional<std::string> SafetyWatch::check_motion(const JointState& truth) const {
  for (int i = 0; i < kArmJoints; ++i) {
    const JointDescription& joint = joints_[std::size_t(i)];
    if (truth.q[i] < joint.lower) {
      return beyond(i, "position", truth.q[i], "is below", joint.lower, "rad");
    }
    if (truth.q[i] > joint.upper) {
      return beyond(i, "position", truth.q[i], "is above", joint.upper, "rad");
    }
    if (std::abs(truth.qd[i]) > joint.velocity) {
      return beyond(i, "speed", truth.qd[i], "exceeds", joint.velocity, "rad/s");
    }
  }
  return std::nullopt;
}

std::optional<std::string> SafetyWatch::check_sensors(const JointVector& tau,
                                                      const JointState& sensed) {
  for (int i = 0; i < kArmJoints; ++i) {
    const bool position = std::isfinite(sensed.q[i] + sensed.theta[i]);
    const bool velocity = std::isfinite(sensed.qd[i] + sensed.theta_d[i]);
    if (position && velocity && std::isfinite(sensed.tau[i])) continue;
    periods_ = 0;
    if (++unreadable_periods_ * kControlPeriod < kPatience) return std::nullopt;
    return fmt::format("joint {}: the {} sensor delivers no number", i + 1,
                       !position   ? "position"
                       : !velocity ? "velocity"
                                   : "torque");
  }
  unreadable_periods_ = 0;

  const JointVector mismatch = (sensed.tau - tau).cwiseAbs();
  if (periods_ == 0) {
    window_start_ = sensed.q;
    travelled_.setZero();
    torque_mismatch_ = mismatch;
    periods_ = 1;
    return std::nullopt;
  }
  travelled_ += kControlPeriod * sensed.qd;
  torque_mismatch_ = torque_mismatch_.cwiseMin(mismatch);
  if (++periods_ <= kWindow) return std::nullopt;
  periods_ = 0;
  for (int i = 0; i < kArmJoints; ++i) {
    const double gap = std::abs(sensed.q[i] - window_start_[i] - travelled_[i]);
    if (gap > kPositionMismatch) {
      return beyond(i, "position and velocity sensors differ by", gap, "over 50 ms, more than",
                    kPositionMismatch, "rad");
    }
    const double allowed = kTorqueMismatch * joints_[std::size_t(i)].effort;
    if (torque_mismatch_[i] > allowed) {
      return beyond(i, "torque sensor and command differ by", torque_mismatch_[i],
                    "for 50 ms, more than", allowed, "Nm");
    }
  }
  return std::nullopt;
}

}  // namespace binpick
