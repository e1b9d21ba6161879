#pragma once

#include <memory>
#include <vector>

#include "control/grasp_selection.h"
#include "control/inverse_kinematics.h"
#include "control/manipulation_automaton.h"
#include "control/robot_skills.h"
#include "control/transfer_planner.h"
#include "models/cell_layout.h"
#include "models/object_model.h"

namespace binpick {

/// Everything that the robot knows before it looks: its own model from the URDF, the gripper, the
/// known objects and the fixed layout of the cell. Immutable; shared by the trials of a worker.
class RobotKnowledge {
 public:
  RobotKnowledge(CellLayout layout, std::vector<ObjectModel> objects,
                 const GraspSelectionOptions& selection = {});
  RobotKnowledge(const RobotKnowledge&) = delete;
  RobotKnowledge& operator=(const RobotKnowledge&) = delete;

  [[nodiscard]] const CellLayout& layout() const noexcept { return layout_; }
  [[nodiscard]] const std::vector<ObjectModel>& objects() const noexcept { return objects_; }
  [[nodiscard]] const GripperDescription& gripper() const noexcept { return gripper_; }
  [[nodiscard]] const ArmModel& arm() const noexcept { return arm_; }
  [[nodiscard]] const InverseKinematics& kinematics() const noexcept { return kinematics_; }
  [[nodiscard]] const TransferPlanner& planner() const noexcept { return planner_; }
  [[nodiscard]] const GraspSelector& selector() const noexcept { return selector_; }

  /// Joint positions for a tool pose, as the grasp selection asks for them: the best posture seen
  /// from the overview pose.
  [[nodiscard]] std::optional<JointVector> reach(const Eigen::Isometry3d& T_world_tcp) const;

  [[nodiscard]] RobotSkills make_skills(Robot& robot, Perception* perception,
                                        const SkillOptions& options) const;

 private:
  CellLayout layout_;
  std::vector<ObjectModel> objects_;
  GripperDescription gripper_;
  ArmModel arm_;
  InverseKinematics kinematics_;
  TransferPlanner planner_;
  GraspSelector selector_;
};

}  // namespace binpick
