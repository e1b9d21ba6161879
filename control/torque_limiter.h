#pragma once

#include <optional>

#include "control/arm_model.h"

namespace binpick {

struct TorqueLimiterOptions {
  double rate = 1000.0;  ///< Nm/s, per joint

  /// @throws InputError if the rate is not positive.
  void validate() const;
};

/// Which torques each joint may have in a period, Nm.
struct TorqueRange {
  JointVector lowest = JointVector::Zero();
  JointVector highest = JointVector::Zero();
};

/// Keeps torques within effort and rate limits.
class TorqueLimiter {
 public:
  TorqueLimiter(const JointLimits& limits, const TorqueLimiterOptions& options);

  /// Gravity and what control adds to it, limited. If a joint would exceed its effort limit, all
  /// of `control` is scaled down alike: the direction of the tool force is kept and the arm never
  /// sags. Then no joint changes faster than the rate limit.
  /// @returns nothing if a torque or `dt` is not finite; the last torques are kept.
  [[nodiscard]] std::optional<JointVector> limit(const JointVector& gravity,
                                                 const JointVector& control, double dt) noexcept;

  /// What effort and rate limits allowed at the last call.
  [[nodiscard]] const TorqueRange& range() const noexcept { return range_; }
  /// Sets the torques from which the rate limit starts. Before the first call of limit() these are
  /// the gravity torques of that call.
  void start(const JointVector& tau) noexcept { last_ = tau; }

  /// Share of the control torques that was let through at the last call; 1 when unsaturated.
  [[nodiscard]] double share() const noexcept { return share_; }

 private:
  TorqueLimiterOptions options_;
  JointVector effort_;
  std::optional<JointVector> last_;
  TorqueRange range_;
  double share_ = 1.0;
};

}  // namespace binpick
