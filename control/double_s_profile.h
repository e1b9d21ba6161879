#pragma once

#include <array>

namespace binpick {

/// Largest speed, acceleration and jerk along a path, in the path's unit per s, s^2, s^3.
struct MotionLimits {
  double velocity = 0.0;
  double acceleration = 0.0;
  double jerk = 0.0;
};

/// Where a motion along a path stands.
struct PathState {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

/// The fastest rest-to-rest motion over a distance under limits on velocity, acceleration and jerk:
/// seven phases of constant jerk, mirrored about the middle, of which some may be empty (Biagiotti
/// and Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, section 3.4).
class DoubleSProfile {
 public:
  /// A motion that is already over.
  DoubleSProfile() = default;
  /// @param distance >= 0.
  /// @throws InputError if a limit is not positive or the distance is negative or not finite.
  DoubleSProfile(double distance, const MotionLimits& limits);

  /// The state at `t`; before 0 the start, after `duration()` the end.
  [[nodiscard]] PathState sample(double t) const noexcept;

  [[nodiscard]] double duration() const noexcept { return scale_ * minimum_duration(); }
  [[nodiscard]] double distance() const noexcept { return distance_; }
  /// Time from rest to the largest velocity, and from there to rest, s.
  [[nodiscard]] double ramp_duration() const noexcept { return scale_ * ramp_; }
  /// The times at which the jerk changes, ascending; the first is 0, the last `duration()`.
  [[nodiscard]] std::array<double, 8> breakpoints() const noexcept;

  /// The same motion drawn out to `duration` (velocity, acceleration and jerk shrink with the
  /// first, second and third power). A duration below the present one changes nothing.
  [[nodiscard]] DoubleSProfile stretched_to(double duration) const noexcept;

 private:
  [[nodiscard]] double minimum_duration() const noexcept { return 2.0 * ramp_ + cruise_; }
  /// During the acceleration, unscaled time in [0, ramp_].
  [[nodiscard]] PathState accelerating(double t) const noexcept;

  double distance_ = 0.0;
  double jerk_ = 0.0;
  double jerk_time_ = 0.0;  // of each of the four jerk phases
  double ramp_ = 0.0;       // acceleration phase, jerk phases included
  double cruise_ = 0.0;
  double scale_ = 1.0;
};

}  // namespace binpick
