#pragma once

#include <filesystem>

#include "models/robot.h"

namespace binpick {

/// The drives of an arm with elastic joints: per joint a rotor, a spring with a damper towards the
/// link, friction on the motor side and a torque sensor on the spring,
///   B theta_dd + tau + D K^-1 tau_d = tau_motor - friction(theta_d),   tau = K (theta - q).
/// All quantities are reflected to the link side of the gear (Albu-Schaeffer, Ott and Hirzinger,
/// IJRR 2007, eqs. 1-3).
struct DriveDescription {
  JointVector motor_inertia = JointVector::Zero();     ///< B, kg m^2
  JointVector stiffness = JointVector::Zero();         ///< K, Nm/rad
  JointVector damping = JointVector::Zero();           ///< D, Nm s/rad
  JointVector coulomb_friction = JointVector::Zero();  ///< Nm
  JointVector viscous_friction = JointVector::Zero();  ///< Nm s/rad
  double torque_noise = 0.0;                           ///< standard deviation of a sample, Nm
  double torque_offset = 0.0;                          ///< offsets lie within +- this, Nm
  double torque_bandwidth = 0.0;                       ///< of the first-order sensor, Hz

  /// The same drives with `factor` times the friction.
  [[nodiscard]] DriveDescription with_friction(double factor) const;
  /// The same drives with sensors free of noise and offset.
  [[nodiscard]] DriveDescription with_ideal_sensors() const;
};

/// @throws InputError with file:line:col.
[[nodiscard]] DriveDescription load_drive_description(const std::filesystem::path& file);

/// The drives of this repository's arm, models/lwr/drives.yaml.
[[nodiscard]] DriveDescription load_lwr_drives();

}  // namespace binpick
