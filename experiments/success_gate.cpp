#include "experiments/success_gate.h"

#include <fmt/format.h>

#include <cmath>

#include "models/errors.h"

namespace binpick {

SuccessGate::SuccessGate(double expected, double drop) {
  const double dropped = expected - drop;
  if (!(0.0 < dropped && dropped < expected && expected < 1.0)) {
    throw InputError(fmt::format(
        "success gate: a drop by {} from a rate of {}; both rates must lie between 0 and 1", drop,
        expected));
  }
  success_step_ = std::log(dropped / expected);
  failure_step_ = std::log((1.0 - dropped) / (1.0 - expected));
}

SuccessGate::Verdict SuccessGate::add(bool success) noexcept {
  if (verdict_ != Verdict::kOpen) return verdict_;
  ++seen_.trials;
  seen_.successes += success ? 1 : 0;
  evidence_ += success ? success_step_ : failure_step_;
  if (evidence_ >= -std::log(kFalseAlarms)) verdict_ = Verdict::kFailed;
  if (evidence_ <= std::log(kMisses)) verdict_ = Verdict::kPassed;
  return verdict_;
}

}  // namespace binpick
