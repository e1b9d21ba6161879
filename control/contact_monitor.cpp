#include "control/contact_monitor.h"

#include <algorithm>
#include <string>

#include "models/errors.h"

namespace binpick {
namespace {

bool any_beyond(const JointVector& residual, const JointVector& threshold) noexcept {
  return (residual.array().abs() >= threshold.array()).any();
}

}  // namespace

ContactThresholds ContactThresholds::for_phase(ContactPhase phase, const JointLimits& limits) {
  ContactThresholds thresholds;
  thresholds.joint_torque = (0.05 * limits.effort).cwiseMax(2.0);
  if (phase != ContactPhase::kFree) thresholds.joint_torque *= 3.0;
  return thresholds;
}

void ContactThresholds::validate() const {
  std::string problems;
  if (!(contact_force > 0.0)) problems += "the contact force must be positive\n";
  if (!(collision_force >= contact_force)) {
    problems += "the collision force must not be below the contact force\n";
  }
  if (!(joint_torque.array() > 0.0).all()) problems += "joint torques must be positive\n";
  if (samples < 1) problems += "at least one sample must make a collision\n";
  if (!(hysteresis > 0.0 && hysteresis <= 1.0)) problems += "the hysteresis must lie in (0, 1]\n";
  if (!problems.empty()) throw InputError("contact thresholds: " + problems);
}

void ContactMonitor::reset() noexcept {
  class_ = ContactClass::kNone;
  samples_over_ = 0;
}

void ContactMonitor::update(const Vector6& wrench, const JointVector& residual) noexcept {
  const ContactThresholds& limit = thresholds_;
  const double force = wrench.head<3>().norm();

  const bool over = force >= limit.collision_force || any_beyond(residual, limit.joint_torque);
  samples_over_ = over ? std::min(samples_over_ + 1, limit.samples) : 0;
  const bool calm = force < limit.hysteresis * limit.collision_force &&
                    !any_beyond(residual, limit.hysteresis * limit.joint_torque);

  if (samples_over_ >= limit.samples || (class_ == ContactClass::kCollision && !calm)) {
    class_ = ContactClass::kCollision;
    return;
  }
  const double contact_force =
      class_ == ContactClass::kNone ? limit.contact_force : limit.hysteresis * limit.contact_force;
  class_ = force >= contact_force ? ContactClass::kContact : ContactClass::kNone;
}

}  // namespace binpick
