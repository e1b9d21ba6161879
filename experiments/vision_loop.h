#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/manipulation_automaton.h"
#include "experiments/arm_offsets.h"
#include "experiments/arm_plant.h"
#include "experiments/recognizer_perception.h"
#include "experiments/referee.h"
#include "experiments/robot_knowledge.h"
#include "experiments/trial_kind.h"
#include "models/config_visitor.h"
#include "sim/depth_camera.h"

namespace binpick {

/// What the vision-based experiments have in common.
struct VisionLoopParameters {
  /// "camera": the recognizer on the depth image. "truth": the oracle TruthPerception.
  std::string perception = "camera";
  /// "paper": the paper's behaviour. "best": with every piece of the strategy. Read before the
  /// pieces: a configuration may choose a setting and change single pieces.
  std::string setting = "paper";
  ManipulationStrategy strategy;
  std::string recognizer = "default";   ///< setting of the recognizer
  bool camera_noise = true;             ///< structured light, or an ideal depth camera
  double stiffness_translation = 2000;  ///< N/m
  double stiffness_rotation = 200;      ///< Nm/rad
  bool reaction = true;
  double collision_force = 15.0;  ///< N
  double approach_speed = 0.1;    ///< m/s
  double closing_speed = 0.1;     ///< of the jaw distance, m/s
  double grip_force = 40.0;       ///< N
  std::string physics = "drawn";  ///< masses and frictions: drawn per trial, or centre
  ArmOffsets offsets;
  double time_budget = 900.0;  ///< simulated, s
  ArmPlantParameters plant;

  void visit(ConfigVisitor& visitor);
  [[nodiscard]] SkillOptions skill_options() const;
  [[nodiscard]] RecognizerOptions recognizer_options() const;
  /// What a VisionCell is made from: equal texts may share one.
  [[nodiscard]] std::string cell_key() const;
};

/// A cell in which the robot can see: compiled world, the robot's knowledge, its recognizer and the
/// camera. Made once per worker and scene; the camera's GL context belongs to the making thread.
struct VisionCell {
  std::shared_ptr<const WorldTemplate> world;
  std::unique_ptr<RobotKnowledge> knowledge;
  std::shared_ptr<const Recognizer> recognizer;
  std::unique_ptr<DepthCamera> camera;

  VisionCell(const std::filesystem::path& scene_file, const VisionLoopParameters& parameters);
};

/// One attempt to grasp, with the truth that the robot did not have.
struct GraspAttempt {
  GraspPlan plan;
  std::optional<Referee::Match> match;  ///< at the moment of grasping
  SkillResult grasp = SkillResult::kDone;
  SkillResult carry = SkillResult::kDone;
  SkillResult place = SkillResult::kDone;

  [[nodiscard]] bool done() const noexcept {
    return grasp == SkillResult::kDone && carry == SkillResult::kDone &&
           place == SkillResult::kDone;
  }
};

/// The outcome and stage that an attempt is booked under; success if it was done.
struct AttemptEnd {
  TrialOutcome outcome = TrialOutcome::kSuccess;
  TrialStage stage = TrialStage::kJudge;
};
[[nodiscard]] AttemptEnd end_of(const GraspAttempt& attempt) noexcept;

/// What became of one run of the automaton.
struct VisionLoopResult {
  AutomatonResult automaton;
  std::vector<GraspAttempt> attempts;
  int pushes = 0;
};

/// Marks the records of trials whose robot was told the truth: measure `oracle_perception`.
void mark_oracle(const VisionLoopParameters& parameters, TrialRecord& record);

/// Closes the loop in a world that is ready: simulated robot, perception, skills and automaton,
/// with the referee's notes beside them. The world's arm is that of `parameters`. Lets the
/// simulation's errors pass; `result` holds what happened until then.
void run_vision_loop(const VisionCell& cell, World& world, const VisionLoopParameters& parameters,
                     const AutomatonOptions& automaton, const TrialContext& context,
                     VisionLoopResult& result);

}  // namespace binpick
