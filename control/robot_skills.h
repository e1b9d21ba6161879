#pragma once

#include <optional>
#include <vector>

#include "control/grasp_clearance.h"
#include "control/inverse_kinematics.h"
#include "control/manipulation_automaton.h"
#include "control/manipulator.h"
#include "control/perception.h"
#include "control/transfer_planner.h"
#include "models/gripper_description.h"

namespace binpick {

/// Speeds, forces and distances of the skills.
struct SkillOptions {
  /// In force while approaching, grasping and placing: N/m and Nm/rad along and about the tool's
  /// axes; y is the jaws' direction.
  Vector6 stiffness = (Vector6() << 2000, 2000, 2000, 200, 200, 200).finished();
  /// Where that stiffness acts: the compliance centre lies so far beyond the tool centre along the
  /// approach vector, m; negative towards the flange.
  double compliance_centre_offset = 0.0;
  std::optional<ElasticJoints> joints;  ///< ArmControllerOptions::joints
  double collision_force = 15.0;        ///< N, while moving freely and approaching
  /// N, while lifting and carrying: the load and what it rubs against are not collisions.
  double loaded_collision_force = 40.0;
  bool reaction = true;  ///< whether a collision ends a motion (Fig. 4) or not (Fig. 7)
  JointMotionOptions free_motion{.speed = 0.7};  ///< transfers with empty jaws
  /// Transfers of a held object: below 1.5 m/s^2 at the tool, so that inertia adds little to the
  /// weight that the pads hold by friction.
  JointMotionOptions loaded_motion{.speed = 0.4, .acceleration_time = 0.8, .jerk_time = 0.3};
  double approach_speed = 0.1;  ///< m/s, along the approach vector
  double lift_speed = 0.2;      ///< m/s
  double lift_height = 0.15;    ///< m
  double lower_speed = 0.1;     ///< m/s, placing
  GripperCommand grip{0.0, 0.1, 40.0};
  double release_margin = 0.03;   ///< the jaws open this much beyond the held width, m
  double place_clearance = 0.01;  ///< lowering may end this far below the expected height, m
};

/// The skills of the automaton on a robot arm: perception, grasp execution and soft placing with
/// impedance control and collision reaction (IJRR 2012, section 5).
class RobotSkills final : public ManipulationSkills {
 public:
  /// Everything must outlive the skills. `perception` may be null for blind work.
  struct Parts {
    Robot& robot;
    Perception* perception;
    const ArmModel& model;
    const InverseKinematics& kinematics;
    const TransferPlanner& planner;
    const GripperDescription& gripper;
    const CellLayout& layout;
  };
  RobotSkills(const Parts& parts, const SkillOptions& options);

  void go_to_overview() override;
  [[nodiscard]] std::vector<Detection> recognize() override;
  [[nodiscard]] int obstruction(const GraspPlan& plan) override;
  /// Transfer to the projected grasp, then `execute_grasp`.
  [[nodiscard]] SkillResult grasp(const GraspPlan& plan) override;
  [[nodiscard]] SkillResult carry(const GraspPlan& plan, const Place& place,
                                  const Eigen::Vector2d& slot) override;
  [[nodiscard]] SkillResult place(const GraspPlan& plan, const Place& place,
                                  const Eigen::Vector2d& slot) override;

  /// From the projected grasp: 0.1 m along the approach vector, jaws closed, lifted.
  [[nodiscard]] SkillResult execute_grasp(const GraspPlan& plan);

  [[nodiscard]] Manipulator& manipulator() noexcept { return manipulator_; }

 private:
  /// Where the tool goes to put the held object down.
  struct Placement {
    Eigen::Isometry3d T_world_above;
    Eigen::Isometry3d T_world_release;
  };

  void enter(ContactPhase phase, double collision_force);
  /// Along a planned path; kUnreachable if there is none.
  [[nodiscard]] SkillResult travel(const std::optional<TransferPlanner::Path>& path,
                                   const JointMotionOptions& motion, const MotionStops& stops);
  void withdraw(double height);
  void weigh();
  [[nodiscard]] MotionStops watching_load() const;
  [[nodiscard]] std::optional<Placement> plan_placement(const GraspPlan& plan, const Place& place,
                                                        const Eigen::Vector2d& slot) const;

  Parts parts_;
  SkillOptions options_;
  Manipulator manipulator_;
  std::optional<GraspClearance> clearance_;
  std::optional<Placement> placement_;
};

}  // namespace binpick
