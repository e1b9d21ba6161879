#pragma once

#include <optional>

#include "control/arm_model.h"

namespace binpick {

/// Offsets of the joint torque sensors: the mean of what they read beyond gravity while the arm
/// stands still and touches nothing. Errors of the gravity model that change sign from pose to pose
/// average out over several poses; in one pose they count as offset.
class SensorCalibration {
 public:
  /// One reading.
  void add(const JointVector& tau, const JointVector& gravity, const JointVector& qd) noexcept;

  /// Nm; nothing if the arm has moved faster than 0.01 rad/s, or before `kLeastSamples` readings.
  [[nodiscard]] std::optional<JointVector> offset() const noexcept;
  static constexpr int kLeastSamples = 100;

 private:
  JointVector sum_ = JointVector::Zero();
  int samples_ = 0;
  double fastest_ = 0.0;
};

}  // namespace binpick
