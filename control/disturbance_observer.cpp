#include "control/disturbance_observer.h"

#include <cmath>

#include "models/errors.h"

namespace binpick {

void DisturbanceObserverOptions::validate() const {
  if (!(gain > 0.0) || !std::isfinite(gain)) {
    throw InputError("disturbance observer: the gain must be positive and finite");
  }
}

DisturbanceObserver::DisturbanceObserver(const DisturbanceObserverOptions& options)
    : options_(options) {
  options_.validate();
}

void DisturbanceObserver::reset() noexcept {
  started_ = false;
  residual_.setZero();
  unfiltered_.setZero();
}

void DisturbanceObserver::update(const ArmDynamics& dynamics, const JointVector& qd,
                                 const JointVector& tau, double dt) noexcept {
  const JointVector bias = dynamics.coriolis + dynamics.gravity;
  if (started_) {
    const JointMatrix M_middle = 0.5 * (dynamics.M + M_);
    const JointVector velocity_change = qd - qd_;
    unfiltered_ = M_middle.lazyProduct(velocity_change) / dt + 0.5 * (bias + bias_) - tau;
    residual_ += -std::expm1(-options_.gain * dt) * (unfiltered_ - residual_);
  }
  started_ = true;
  M_ = dynamics.M;
  bias_ = bias;
  qd_ = qd;
}

}  // namespace binpick
