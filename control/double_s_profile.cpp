#include "control/double_s_profile.h"

#include <fmt/format.h>

#include <cmath>

#include "models/errors.h"

namespace binpick {

DoubleSProfile::DoubleSProfile(double distance, const MotionLimits& limits)
    : distance_(distance), jerk_(limits.jerk) {
  if (!(limits.velocity > 0.0) || !(limits.acceleration > 0.0) || !(limits.jerk > 0.0)) {
    throw InputError(
        fmt::format("motion limits: velocity {}, acceleration {} and jerk {} must all "
                    "be positive",
                    limits.velocity, limits.acceleration, limits.jerk));
  }
  if (!(distance >= 0.0) || !std::isfinite(distance)) {
    throw InputError(fmt::format("distance {}: must be finite and not negative", distance));
  }
  const double v = limits.velocity;
  const double a = limits.acceleration;
  const double j = limits.jerk;
  if (v * j < a * a) {
    jerk_time_ = std::sqrt(v / j);
    ramp_ = 2.0 * jerk_time_;
  } else {
    jerk_time_ = a / j;
    ramp_ = jerk_time_ + v / a;
  }
  cruise_ = distance / v - ramp_;
  if (cruise_ >= 0.0) return;

  // Too short for the full velocity.
  cruise_ = 0.0;
  jerk_time_ = a / j;
  if (distance >= 2.0 * a * jerk_time_ * jerk_time_) {
    ramp_ = 0.5 * jerk_time_ + std::sqrt(0.25 * jerk_time_ * jerk_time_ + distance / a);
  } else {
    jerk_time_ = std::cbrt(distance / (2.0 * j));
    ramp_ = 2.0 * jerk_time_;
  }
}

PathState DoubleSProfile::accelerating(double t) const noexcept {
  const double acceleration = jerk_ * jerk_time_;
  const double velocity = acceleration * (ramp_ - jerk_time_);
  if (t < jerk_time_) {
    return {jerk_ * t * t * t / 6.0, 0.5 * jerk_ * t * t, jerk_ * t};
  }
  if (t < ramp_ - jerk_time_) {
    return {acceleration * (3.0 * t * (t - jerk_time_) + jerk_time_ * jerk_time_) / 6.0,
            acceleration * (t - 0.5 * jerk_time_), acceleration};
  }
  const double rest = ramp_ - t;
  return {velocity * (0.5 * ramp_ - rest) + jerk_ * rest * rest * rest / 6.0,
          velocity - 0.5 * jerk_ * rest * rest, jerk_ * rest};
}

PathState DoubleSProfile::sample(double t) const noexcept {
  const double time = t / scale_;
  const double end = minimum_duration();
  if (!(time > 0.0)) return {};
  if (time >= end) return {distance_, 0.0, 0.0};

  PathState state;
  if (time < ramp_) {
    state = accelerating(time);
  } else if (time <= ramp_ + cruise_) {
    const double velocity = jerk_ * jerk_time_ * (ramp_ - jerk_time_);
    state = {velocity * (time - 0.5 * ramp_), velocity, 0.0};
  } else {
    state = accelerating(end - time);
    state = {distance_ - state.position, state.velocity, -state.acceleration};
  }
  state.velocity /= scale_;
  state.acceleration /= scale_ * scale_;
  return state;
}

std::array<double, 8> DoubleSProfile::breakpoints() const noexcept {
  const double end = minimum_duration();
  std::array<double, 8> times{0.0,
                              jerk_time_,
                              ramp_ - jerk_time_,
                              ramp_,
                              end - ramp_,
                              end - ramp_ + jerk_time_,
                              end - jerk_time_,
                              end};
  for (double& time : times) time *= scale_;
  return times;
}

DoubleSProfile DoubleSProfile::stretched_to(double duration) const noexcept {
  DoubleSProfile slower = *this;
  if (duration > this->duration() && minimum_duration() > 0.0) {
    slower.scale_ = duration / minimum_duration();
  }
  return slower;
}

}  // namespace binpick
