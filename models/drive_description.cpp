#include "models/drive_description.h"

#include "models/config_visitor.h"
#include "models/object_model.h"
#include "models/yaml_config.h"

namespace binpick {

DriveDescription DriveDescription::with_friction(double factor) const {
  DriveDescription drives = *this;
  drives.coulomb_friction *= factor;
  drives.viscous_friction *= factor;
  return drives;
}

DriveDescription DriveDescription::with_ideal_sensors() const {
  DriveDescription drives = *this;
  drives.torque_noise = 0.0;
  drives.torque_offset = 0.0;
  return drives;
}

DriveDescription load_drive_description(const std::filesystem::path& file) {
  DriveDescription drives;
  double damping_ratio = 0.0;
  read_yaml(file, [&](ConfigVisitor& visitor) {
    const auto required = Presence::kRequired;
    visitor.vector("motor_inertia", drives.motor_inertia, {0.001, 100.0, 1.0}, required);
    visitor.vector("stiffness", drives.stiffness, {100.0, 1e6, 1.0}, required);
    visitor.number("damping_ratio", damping_ratio, {0.0, 1.0, 1.0}, required);
    visitor.vector("coulomb_friction", drives.coulomb_friction, {0.0, 100.0, 1.0}, required);
    visitor.vector("viscous_friction", drives.viscous_friction, {0.0, 1000.0, 1.0}, required);
    visitor.number("torque_noise", drives.torque_noise, {0.0, 10.0, 1.0}, required);
    visitor.number("torque_offset", drives.torque_offset, {0.0, 10.0, 1.0}, required);
    visitor.number("torque_bandwidth_hz", drives.torque_bandwidth, {10.0, 1e6, 1.0}, required);
  });
  drives.damping =
      2.0 * damping_ratio * drives.stiffness.cwiseProduct(drives.motor_inertia).cwiseSqrt();
  return drives;
}

DriveDescription load_lwr_drives() {
  return load_drive_description(models_directory() / "lwr" / "drives.yaml");
}

}  // namespace binpick
