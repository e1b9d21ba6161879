#pragma once

#include <optional>
#include <string>

#include "control/arm_controller.h"
#include "control/robot_skills.h"
#include "models/config_visitor.h"
#include "sim/simulated_robot.h"

namespace binpick {

/// Which arm the world simulates: the part of an experiment's parameters that says so.
struct ArmPlantParameters {
  std::string joints = "rigid";  ///< rigid, or elastic as models/lwr/drives.yaml describes them
  double motor_friction = 1.0;   ///< times the described friction; elastic joints only
  bool torque_errors = true;     ///< the described noise and offsets; elastic joints only

  void visit(ConfigVisitor& visitor);
  /// Nothing for rigid joints.
  [[nodiscard]] std::optional<DriveDescription> drives() const;
};

/// Both sides of the arm's drives: what the world is built with, and the brain's knowledge of them
/// with the torque loop that it runs inside them. Must outlive robots that use it.
class ArmPlant {
 public:
  /// @throws InputError
  explicit ArmPlant(const ArmPlantParameters& parameters);
  ArmPlant(const ArmPlant&) = delete;
  ArmPlant& operator=(const ArmPlant&) = delete;

  [[nodiscard]] const std::optional<DriveDescription>& drives() const noexcept { return drives_; }
  /// Enters sensor noise and torque loop.
  void configure(SimulatedRobotOptions& options) const;
  /// Enters what the controller knows of the joints.
  void configure(ArmControllerOptions& options) const;
  void configure(SkillOptions& options) const;

 private:
  std::optional<DriveDescription> drives_;
  std::optional<ElasticJoints> joints_;
  std::optional<TorqueFeedback> feedback_;
};

}  // namespace binpick
