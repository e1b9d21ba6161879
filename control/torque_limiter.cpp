#include "control/torque_limiter.h"

#include <algorithm>
#include <cmath>

#include "models/errors.h"

namespace binpick {

void TorqueLimiterOptions::validate() const {
  if (!(rate > 0.0)) throw InputError("torque limiter: the rate must be positive");
}

TorqueLimiter::TorqueLimiter(const JointLimits& limits, const TorqueLimiterOptions& options)
    : options_(options), effort_(limits.effort) {
  options_.validate();
}

std::optional<JointVector> TorqueLimiter::limit(const JointVector& gravity,
                                                const JointVector& control, double dt) noexcept {
  if (!gravity.allFinite() || !control.allFinite() || !std::isfinite(dt)) return std::nullopt;

  share_ = 1.0;
  for (int i = 0; i < kArmJoints; ++i) {
    const double room = std::max(effort_[i] - std::copysign(1.0, control[i]) * gravity[i], 0.0);
    if (std::abs(control[i]) > room) share_ = std::min(share_, room / std::abs(control[i]));
  }
  // Gravity alone is beyond a joint's limit only in poses that the arm cannot hold at all.
  if (!last_) last_ = gravity.cwiseMax(-effort_).cwiseMin(effort_);
  const JointVector step = JointVector::Constant(options_.rate * dt);
  range_.highest = (*last_ + step).cwiseMin(effort_);
  range_.lowest = (*last_ - step).cwiseMax(-effort_);
  last_ = (gravity + share_ * control).cwiseMax(range_.lowest).cwiseMin(range_.highest);
  return last_;
}

}  // namespace binpick
