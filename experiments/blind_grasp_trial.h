#pragma once

#include <memory>
#include <string>

#include "experiments/arm_offsets.h"
#include "experiments/arm_plant.h"
#include "experiments/robot_knowledge.h"
#include "experiments/trial_kind.h"
#include "scenes/scene.h"
#include "sim/world.h"

namespace binpick {

/// Table 1 (IJRR 2012, section 6.2): the bottle is grasped without looking, after it has been moved
/// by a fixed distance in a random direction parallel to the table. Protocol: docs/table1.md, which
/// also says which parameters its sensitivity study sweeps.
class BlindGraspTrial final : public TrialKind {
 public:
  void visit(ConfigVisitor& visitor) override;
  void prepare(const std::filesystem::path& config_directory) override;
  [[nodiscard]] std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const override;
  [[nodiscard]] TrialRecord run(const TrialContext& context) override;

 private:
  /// Values that hold in all trials in place of a draw; 0: drawn.
  struct FixedPhysics {
    double mass = 0.0;  ///< kg
    double table_friction = 0.0;
    double pad_friction = 0.0;
    double closing_speed = 0.0;  ///< m/s

    void visit(ConfigVisitor& visitor);
  };
  struct Parameters {
    std::string scene;            ///< one object
    std::string grasp;            ///< name of a stored grasp of that object
    double grasp_turn = 0.0;      ///< turns the jaws about the approach vector, rad
    double grasp_tilt = 0.0;      ///< leans the hand about the jaws' axis, rad
    double grasp_raise = 0.0;     ///< moves the tool centre against the approach vector, m
    double pre_opening = 0.0;     ///< m; 0: the stored grasp's
    double pad_width = 0.0;       ///< m; 0: the gripper's
    double pose_error = 0.015;    ///< m
    double stiffness_x = 2000.0;  ///< N/m, along the tool's axes; y is the jaws' direction
    double stiffness_y = 2000.0;
    double stiffness_z = 2000.0;
    double stiffness_rx = 200.0;  ///< Nm/rad, about them
    double stiffness_ry = 200.0;
    double stiffness_rz = 200.0;
    double compliance_centre_offset = 0.0;  ///< SkillOptions, m
    bool reaction = true;
    double collision_force = 15.0;       ///< N
    double approach_speed = 0.1;         ///< m/s
    Interval closing_speed{0.05, 0.15};  ///< of the jaw distance, m/s; drawn per trial
    double grip_force = 40.0;            ///< N
    double lift_height = 0.15;           ///< m
    double hold_time = 3.0;              ///< s
    ArmOffsets offsets;
    std::string physics = "drawn";  ///< masses and frictions: drawn per trial, or centre
    FixedPhysics fixed;
    ArmPlantParameters plant;

    void visit(ConfigVisitor& visitor);
  };

  /// Compiles the cell, with other pads if asked to.
  void load_world(const std::string& scene_file);
  /// The robot's objects: as in the world, with the grasp adjusted.
  [[nodiscard]] std::vector<ObjectModel> objects_to_grasp() const;
  [[nodiscard]] PhysicsDraw physics(const TrialContext& context) const;
  [[nodiscard]] GraspPlan nominal_plan(const World& world) const;
  void attempt(const TrialContext& context, TrialRecord& record) const;
  [[nodiscard]] SkillOptions skill_options(const TrialContext& context) const;

  Parameters parameters_;
  std::string loaded_cell_;   ///< what world_ was made for
  std::string loaded_grasp_;  ///< what knowledge_ was made for
  std::shared_ptr<const WorldTemplate> world_;
  std::unique_ptr<RobotKnowledge> knowledge_;
};

}  // namespace binpick
