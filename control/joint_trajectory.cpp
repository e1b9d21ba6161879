#include "control/joint_trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr double kSamePosition = 1e-9;  // rad

struct VectorLimits {
  JointVector velocity;
  JointVector acceleration;
  JointVector jerk;
};

VectorLimits motion_limits(const JointLimits& limits, const JointMotionOptions& options) {
  VectorLimits motion;
  motion.velocity = options.speed * limits.velocity;
  motion.acceleration = limits.velocity / options.acceleration_time;
  motion.jerk = motion.acceleration / options.jerk_time;
  return motion;
}

/// The limits of a parameter in [0, 1] that moves the joints by `delta`.
MotionLimits along(const JointVector& delta, const VectorLimits& limits) {
  constexpr double kUnlimited = std::numeric_limits<double>::max();
  MotionLimits scalar{kUnlimited, kUnlimited, kUnlimited};
  for (int i = 0; i < kArmJoints; ++i) {
    const double travel = std::abs(delta[i]);
    if (travel < 1e-12) continue;
    scalar.velocity = std::min(scalar.velocity, limits.velocity[i] / travel);
    scalar.acceleration = std::min(scalar.acceleration, limits.acceleration[i] / travel);
    scalar.jerk = std::min(scalar.jerk, limits.jerk[i] / travel);
  }
  return scalar;
}

void check(const std::vector<JointVector>& waypoints, const JointLimits& limits,
           const JointMotionOptions& options) {
  if (waypoints.empty()) {
    throw InputError("joint trajectory: give at least one waypoint");
  }
  for (std::size_t k = 0; k < waypoints.size(); ++k) {
    for (int i = 0; i < kArmJoints; ++i) {
      const double q = waypoints[k][i];
      // The arm may stand a little beyond a limit; it must be able to come back.
      if (k == 0 && std::isfinite(q)) continue;
      if (!(q >= limits.lower[i] - kSamePosition && q <= limits.upper[i] + kSamePosition)) {
        throw InputError(fmt::format(
            "joint trajectory: waypoint {}, joint {}: {:.4f} rad is outside [{:.4f}, {:.4f}]", k,
            i + 1, q, limits.lower[i], limits.upper[i]));
      }
    }
  }
  if (!(options.speed > 0.0 && options.speed <= 1.0) ||
      !(options.blend >= 0.0 && options.blend <= 1.0) || !(options.acceleration_time > 0.0) ||
      !(options.jerk_time > 0.0)) {
    throw InputError(fmt::format(
        "joint trajectory: speed {} must be in (0, 1], blend {} in [0, 1], acceleration_time {} "
        "and jerk_time {} positive",
        options.speed, options.blend, options.acceleration_time, options.jerk_time));
  }
}

/// A double-S motion over `delta` that sets off at `start`.
struct Stroke {
  const DoubleSProfile* profile;
  double start;
  const JointVector* delta;
};

/// Whether the sum of two motions keeps velocity and acceleration limits.
bool keeps_limits(const Stroke& first, const Stroke& second, const JointVector& velocity,
                  const JointVector& acceleration) {
  constexpr double kSlack = 1.0 + 1e-9;
  std::array<double, 16> times{};
  std::size_t count = 0;
  for (const Stroke& stroke : {first, second}) {
    for (const double t : stroke.profile->breakpoints()) times[count++] = stroke.start + t;
  }
  std::sort(times.begin(), times.end());

  JointVector qd_before = JointVector::Zero();
  JointVector qdd_before = JointVector::Zero();
  for (std::size_t k = 0; k < count; ++k) {
    const PathState a = first.profile->sample(times[k] - first.start);
    const PathState b = second.profile->sample(times[k] - second.start);
    const JointVector qd = a.velocity * *first.delta + b.velocity * *second.delta;
    const JointVector qdd = a.acceleration * *first.delta + b.acceleration * *second.delta;
    if ((qdd.cwiseAbs() - kSlack * acceleration).maxCoeff() > 0.0) return false;
    if ((qd.cwiseAbs() - kSlack * velocity).maxCoeff() > 0.0) return false;
    // Between two times the jerk is constant: where the acceleration changes its sign, the
    // velocity, a parabola, has its vertex.
    const double span = k == 0 ? 0.0 : times[k] - times[k - 1];
    for (int i = 0; i < kArmJoints && span > 0.0; ++i) {
      if (qdd_before[i] * qdd[i] >= 0.0) continue;
      const double jerk = (qdd[i] - qdd_before[i]) / span;
      const double vertex = qd_before[i] - 0.5 * qdd_before[i] * qdd_before[i] / jerk;
      if (std::abs(vertex) > kSlack * velocity[i]) return false;
    }
    qd_before = qd;
    qdd_before = qdd;
  }
  return true;
}

}  // namespace

JointTrajectory::JointTrajectory(const JointVector& q) : start_(q), goal_(q) {}

JointTrajectory::JointTrajectory(const std::vector<JointVector>& waypoints,
                                 const JointLimits& limits, const JointMotionOptions& options) {
  check(waypoints, limits, options);
  start_ = waypoints.front();
  goal_ = waypoints.back();
  const VectorLimits allowed = motion_limits(limits, options);
  for (const JointVector& waypoint : waypoints) {
    const JointVector from =
        segments_.empty() ? start_ : JointVector(segments_.back().from + segments_.back().delta);
    Segment segment;
    segment.from = from;
    segment.delta = waypoint - from;
    if (segment.delta.cwiseAbs().maxCoeff() < kSamePosition) continue;
    segment.profile = DoubleSProfile(1.0, along(segment.delta, allowed));
    if (!segments_.empty()) {
      const Segment& last = segments_.back();
      const double longest =
          options.blend * std::min(last.profile.ramp_duration(), segment.profile.ramp_duration());
      segment.start =
          last.end() - overlap(last, segment, longest, allowed.velocity, allowed.acceleration);
    }
    segments_.push_back(segment);
  }
}

double JointTrajectory::overlap(const Segment& last, Segment next, double longest,
                                const JointVector& velocity, const JointVector& acceleration) {
  const auto within_limits = [&](double overlapping) {
    next.start = last.end() - overlapping;
    return keeps_limits({&last.profile, last.start, &last.delta},
                        {&next.profile, next.start, &next.delta}, velocity, acceleration);
  };
  if (within_limits(longest)) return longest;
  double possible = 0.0;
  double excessive = longest;
  constexpr int kBisections = 20;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (possible + excessive);
    (within_limits(middle) ? possible : excessive) = middle;
  }
  return possible;
}

JointTarget JointTrajectory::unscaled(double time) const noexcept {
  const auto later =
      std::upper_bound(segments_.begin(), segments_.end(), time,
                       [](double t, const Segment& segment) { return t < segment.start; });
  if (later == segments_.begin()) return {start_, JointVector::Zero(), JointVector::Zero()};

  // A ramp is at most half a segment, so that no more than two segments are under way at once.
  const Segment& present = *std::prev(later);
  const PathState state = present.profile.sample(time - present.start);
  JointTarget sample;
  sample.q = present.from + state.position * present.delta;
  sample.qd = state.velocity * present.delta;
  sample.qdd = state.acceleration * present.delta;
  if (std::prev(later) != segments_.begin()) {
    const Segment& last = *std::prev(later, 2);
    const PathState braking = last.profile.sample(time - last.start);
    sample.q += (braking.position - 1.0) * last.delta;
    sample.qd += braking.velocity * last.delta;
    sample.qdd += braking.acceleration * last.delta;
  }
  return sample;
}

JointTarget JointTrajectory::sample(double t) const noexcept {
  if (!(t > 0.0)) return {start_, JointVector::Zero(), JointVector::Zero()};
  if (t >= duration()) return {goal_, JointVector::Zero(), JointVector::Zero()};
  JointTarget sample = unscaled(t / scale_);
  sample.qd /= scale_;
  sample.qdd /= scale_ * scale_;
  return sample;
}

double JointTrajectory::duration() const noexcept {
  return segments_.empty() ? 0.0 : scale_ * segments_.back().end();
}

JointTrajectory JointTrajectory::stretched_to(double duration) const {
  JointTrajectory slower = *this;
  if (duration > this->duration() && !segments_.empty()) {
    slower.scale_ = duration / segments_.back().end();
  }
  return slower;
}

}  // namespace binpick
