#include "control/sensor_calibration.h"

#include <algorithm>

namespace binpick {
namespace {

constexpr double kStandstill = 0.01;  // rad/s

}  // namespace

void SensorCalibration::add(const JointVector& tau, const JointVector& gravity,
                            const JointVector& qd) noexcept {
  sum_ += tau - gravity;
  ++samples_;
  fastest_ = std::max(fastest_, qd.cwiseAbs().maxCoeff());
}

std::optional<JointVector> SensorCalibration::offset() const noexcept {
  if (samples_ < kLeastSamples || fastest_ > kStandstill) return std::nullopt;
  return sum_ / samples_;
}

}  // namespace binpick
