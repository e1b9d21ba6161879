#pragma once

#include <memory>
#include <string>

#include "experiments/arm_plant.h"
#include "experiments/contact_series.h"
#include "experiments/robot_knowledge.h"
#include "experiments/trial_kind.h"
#include "sim/world_template.h"

namespace binpick {

/// Figs. 5 and 6 (IJRR 2012, section 5.2): the tool, empty or with a held block, comes down on a
/// surface of known stiffness and presses on, with or without collision detection and reaction.
/// Protocol: docs/fig05_07.md.
class ContactTrial final : public TrialKind {
 public:
  void visit(ConfigVisitor& visitor) override;
  void prepare(const std::filesystem::path& config_directory) override;
  [[nodiscard]] std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const override;
  /// With a trace asked for, writes `contact.csv` (contact_series.h) beside it.
  [[nodiscard]] TrialRecord run(const TrialContext& context) override;
  /// The run behind a record. Ends early where the record's outcome says so.
  [[nodiscard]] ContactSeries time_series(const TrialContext& context) const;

 private:
  struct Parameters {
    std::string scene;            ///< its objects are taken away
    double height = 0.15;         ///< of the surface, m
    double approach = 0.08;       ///< from the start to the surface, m
    double overshoot = 0.06;      ///< of the goal below the surface, m
    double speed = 0.1;           ///< of the set-point, m/s
    double hold_time = 1.0;       ///< after the motion, s
    double stiffness_z = 4000.0;  ///< N/m
    double stiffness_xy = 2000.0;
    double stiffness_rotation = 200.0;  ///< Nm/rad
    bool reaction = true;
    double collision_force = 15.0;       ///< N
    double contact_stiffness = 30000.0;  ///< of the surface, N/m
    double held_mass = 0.0;              ///< kg; a block between the jaws that rests on the palm
    double held_length = 0.05;           ///< by which it reaches beyond the tool centre, m
    ArmPlantParameters plant;
  };

  /// Fills `series` as the run goes on, and `record` at its end.
  void press(const TrialContext& context, ContactSeries& series, TrialRecord& record) const;
  [[nodiscard]] ArmControllerOptions controller_options(const ArmPlant& plant) const;
  [[nodiscard]] CompliantSurface surface() const;
  /// What the jaws hold, tool-centre frame.
  [[nodiscard]] BodyInertia held_block() const;

  Parameters parameters_;
  std::string loaded_;
  std::shared_ptr<const WorldTemplate> world_;
  std::unique_ptr<RobotKnowledge> knowledge_;
  std::unique_ptr<ArmModel> arm_;  ///< with the wrist speeds of this experiment
};

}  // namespace binpick
