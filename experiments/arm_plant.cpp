#include "experiments/arm_plant.h"

namespace binpick {

void ArmPlantParameters::visit(ConfigVisitor& visitor) {
  visitor.choice("joints", joints, {"rigid", "elastic"});
  visitor.number("motor_friction", motor_friction, {.min = 0.0, .max = 10.0});
  visitor.boolean("torque_errors", torque_errors);
}

std::optional<DriveDescription> ArmPlantParameters::drives() const {
  if (joints == "rigid") return std::nullopt;
  const DriveDescription described = load_lwr_drives().with_friction(motor_friction);
  return torque_errors ? described : described.with_ideal_sensors();
}

ArmPlant::ArmPlant(const ArmPlantParameters& parameters) : drives_(parameters.drives()) {
  if (!drives_) return;
  joints_ = ElasticJoints::of(*drives_);
  feedback_.emplace(*joints_);
}

void ArmPlant::configure(SimulatedRobotOptions& options) const {
  if (!drives_) return;
  options.sensor_noise = {drives_->torque_noise, drives_->torque_offset};
  options.torque_loop = feedback_->loop();
}

void ArmPlant::configure(ArmControllerOptions& options) const { options.joints = joints_; }

void ArmPlant::configure(SkillOptions& options) const { options.joints = joints_; }

}  // namespace binpick
