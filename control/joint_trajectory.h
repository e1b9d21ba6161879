#pragma once

#include <cstddef>
#include <vector>

#include "control/arm_model.h"
#include "control/double_s_profile.h"
#include "control/motion_target.h"

namespace binpick {

/// How fast a joint motion may be.
struct JointMotionOptions {
  /// Fraction of the joints' velocity limits that is used. (0, 1]
  double speed = 0.5;
  /// Time in which a joint could reach its velocity limit, s: acceleration limit = velocity limit /
  /// this. 0.3 s asks for 6.4 rad/s^2 at the shoulder, some 40 Nm with rotors, well inside the
  /// 176 Nm of the joint.
  double acceleration_time = 0.3;
  /// Time in which a joint may build up that acceleration, s.
  double jerk_time = 0.1;
  /// How much of the ramps of successive segments overlaps. 0: the arm stops at every waypoint;
  /// 1: it turns from one segment into the next without loss of time and cuts the corner by up to
  /// half a ramp's travel. [0, 1]
  double blend = 0.5;
};

/// A motion through waypoints, from rest to rest. Between two waypoints all joints move on a
/// straight line in joint space with one double-S profile (so all start and stop together).
/// Successive segments overlap in time: the next one sets off while the last one brakes, so that
/// the path stays in the triangle of the three waypoints. Where the sum of the two would break a
/// velocity or acceleration limit they overlap less; the peaks are found exactly, not by sampling.
/// The jerk limit holds for each segment; in an overlap the sum may reach twice as much.
class JointTrajectory {
 public:
  /// Standing still at `q`.
  explicit JointTrajectory(const JointVector& q);
  /// @param waypoints at least one; the first is where the arm stands. Equal neighbours are merged.
  /// @throws InputError for no waypoints, a waypoint that is not finite or, save the first, beyond
  /// the position limits, or options outside their ranges.
  JointTrajectory(const std::vector<JointVector>& waypoints, const JointLimits& limits,
                  const JointMotionOptions& options = {});

  /// Before 0 the start, after `duration()` the end. O(log segments), allocates nothing.
  [[nodiscard]] JointTarget sample(double t) const noexcept;

  [[nodiscard]] double duration() const noexcept;
  [[nodiscard]] const JointVector& start() const noexcept { return start_; }
  [[nodiscard]] const JointVector& goal() const noexcept { return goal_; }

  /// The same motion drawn out to `duration`; a shorter one changes nothing.
  [[nodiscard]] JointTrajectory stretched_to(double duration) const;

 private:
  struct Segment {
    JointVector from;
    JointVector delta;
    DoubleSProfile profile;  // over [0, 1]
    double start = 0.0;      // unscaled time, s

    [[nodiscard]] double end() const noexcept { return start + profile.duration(); }
  };

  /// How long `next` may overlap with `last`, at most `longest`, within the limits.
  [[nodiscard]] static double overlap(const Segment& last, Segment next, double longest,
                                      const JointVector& velocity, const JointVector& acceleration);
  [[nodiscard]] JointTarget unscaled(double time) const noexcept;

  JointVector start_;
  JointVector goal_;
  std::vector<Segment> segments_;
  double scale_ = 1.0;
};

}  // namespace binpick
