#pragma once

#include <optional>
#include <vector>

#include "control/grasp_clearance.h"
#include "control/inverse_kinematics.h"
#include "control/manipulation_automaton.h"
#include "control/manipulation_strategy.h"
#include "control/manipulator.h"
#include "control/perception.h"
#include "control/push_planner.h"
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
  double withdraw_speed = 0.4;  ///< m/s, upward with empty jaws
  double sink_speed = 0.25;     ///< m/s, placing, as long as contact cannot be near
  double lower_speed = 0.1;     ///< m/s, placing, where contact is expected
  GripperCommand grip{0.0, 0.1, 40.0};
  double release_margin = 0.03;   ///< the jaws open this much beyond the held width, m
  double place_clearance = 0.01;  ///< lowering may end this far below the expected height, m

  ManipulationStrategy strategy;
  /// Verification: what is held is as wide as the grasp expects, give or take this, m. More than
  /// lies between a bottle's waist and belt (11 mm), less than between its axes (33 mm).
  double width_tolerance = 0.025;
  /// Verification: it weighs at least this share of the lightest known object of its kind.
  double least_load = 0.5;
  /// Second look: a view is doubtful when one of its detections is less likely than this.
  double doubtful_confidence = 0.9;
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
    const std::vector<ObjectModel>& objects;
  };
  RobotSkills(const Parts& parts, const SkillOptions& options);

  void go_to_overview() override;
  [[nodiscard]] std::vector<Detection> recognize() override;
  [[nodiscard]] int obstruction(const GraspPlan& plan) override;
  [[nodiscard]] double hidden_share(const GraspPlan& plan) override;
  [[nodiscard]] bool has_way(const GraspPlan& plan, const Place& place,
                             const Eigen::Vector2d& slot) override;
  /// Transfer to the projected grasp, then `execute_grasp`.
  [[nodiscard]] SkillResult grasp(const GraspPlan& plan) override;
  [[nodiscard]] SkillResult carry(const GraspPlan& plan, const Place& place,
                                  const Eigen::Vector2d& slot) override;
  [[nodiscard]] SkillResult place(const GraspPlan& plan, const Place& place,
                                  const Eigen::Vector2d& slot) override;

  [[nodiscard]] std::vector<Eigen::Vector3d> unrecognized_surface() override;
  [[nodiscard]] SkillResult push(const std::vector<Eigen::Vector3d>& surface) override;

  /// From the projected grasp: 0.1 m along the approach vector, jaws closed, lifted.
  [[nodiscard]] SkillResult execute_grasp(const GraspPlan& plan);

  [[nodiscard]] Manipulator& manipulator() noexcept { return manipulator_; }

 private:
  /// Where the tool goes to put the held object down. The lower the cost the better.
  struct Placement {
    Eigen::Isometry3d T_world_above;
    Eigen::Isometry3d T_world_release;
    double cost = 0.0;
  };
  /// A placement and the way there.
  struct Delivery {
    Placement placement;
    TransferPlanner::Path path;
  };
  /// What is between the jaws after lifting.
  struct Hold {
    double width = 0.0;  ///< m
    double mass = 0.0;   ///< kg
  };

  void enter(ContactPhase phase, double collision_force);
  /// Of what was seen last in the pick region, over the table, m.
  [[nodiscard]] double pile_height() const;
  /// A path from `from` to `to`, a posture or a pose of the tool: over the highest pile that there
  /// may be or, with the strategy's search, over what was seen last.
  template <class Goal>
  [[nodiscard]] std::optional<TransferPlanner::Path> find_path(const JointVector& from,
                                                               const Goal& to) const;
  /// Along a planned path; kUnreachable if there is none.
  [[nodiscard]] SkillResult travel(const std::optional<TransferPlanner::Path>& path,
                                   const JointMotionOptions& motion, const MotionStops& stops);
  void return_to_overview();
  void withdraw(double height);
  [[nodiscard]] std::vector<Detection> look();
  [[nodiscard]] const ObjectModel* find_object(const std::string& name) const;
  /// The straight way from one tool pose to another; where the arm is then, nothing if it cannot.
  [[nodiscard]] std::optional<JointVector> after_line(const Eigen::Isometry3d& T_world_start,
                                                      const Eigen::Isometry3d& T_world_goal,
                                                      const JointVector& q) const;
  void weigh();
  [[nodiscard]] bool holds_as_planned(const GraspPlan& plan) const;
  [[nodiscard]] bool still_holds();
  /// Down to where it was grasped, or until contact, and let go.
  void put_back(const GraspPlan& plan);
  void let_go();
  [[nodiscard]] MotionStops watching_load() const;
  /// Placements that the arm reaches from `q`, the best first.
  [[nodiscard]] std::vector<Placement> placements(const GraspPlan& plan, const Place& place,
                                                  const Eigen::Vector2d& slot,
                                                  const JointVector& q) const;
  /// The best placement that there is a path to from `q`.
  [[nodiscard]] std::optional<Delivery> plan_delivery(const GraspPlan& plan, const Place& place,
                                                      const Eigen::Vector2d& slot,
                                                      const JointVector& q) const;

  Parts parts_;
  SkillOptions options_;
  Manipulator manipulator_;
  std::optional<GraspClearance> clearance_;
  /// Over what was seen last, for when there is no way over the highest pile that there may be.
  std::optional<TransferPlanner> low_planner_;
  std::optional<Placement> placement_;
  Hold hold_;
  bool calibrated_ = false;  ///< the torque sensors' offsets have been taken
};

}  // namespace binpick
