#pragma once

#include "experiments/proportions.h"

namespace binpick {

/// Guards a success rate: fed with trials one after the other, it says as early as it can whether
/// the rate is still what it was or has dropped. Wald's sequential probability ratio test (Wald
/// 1945) of `expected` against `expected - drop`, with his boundaries moved outwards to 1 / alpha
/// and beta, where both promises hold exactly and not only nearly:
///   * a rate of `expected` or more fails in at most kFalseAlarms of all sequences,
///   * a rate of `expected - drop` or less passes in at most kMisses of them.
/// It ends with probability one: a sound system of 0.9 or more passes after 25 trials on average.
class SuccessGate {
 public:
  static constexpr double kFalseAlarms = 0.01;
  static constexpr double kMisses = 0.1;

  enum class Verdict { kOpen, kPassed, kFailed };

  /// @param expected the rate of the sound system, below 1: an all-time best of "always" fails at
  /// the first accident. @throws InputError unless 0 < expected - drop < expected < 1.
  explicit SuccessGate(double expected, double drop = 0.15);

  /// Trials after the verdict change nothing.
  Verdict add(bool success) noexcept;
  [[nodiscard]] Verdict verdict() const noexcept { return verdict_; }
  [[nodiscard]] const Proportion& seen() const noexcept { return seen_; }

 private:
  double success_step_;  ///< what a success adds to the log-likelihood ratio, drop over no drop
  double failure_step_;
  double evidence_ = 0.0;
  Verdict verdict_ = Verdict::kOpen;
  Proportion seen_;
};

}  // namespace binpick
