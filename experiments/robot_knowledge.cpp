#include "experiments/robot_knowledge.h"

namespace binpick {

RobotKnowledge::RobotKnowledge(CellLayout layout, std::vector<ObjectModel> objects,
                               const GraspSelectionOptions& selection)
    : layout_(std::move(layout)),
      objects_(std::move(objects)),
      gripper_(load_gripper()),
      arm_(load_lwr(), gripper_, layout_.T_world_base),
      kinematics_(arm_),
      planner_(arm_, kinematics_, layout_),
      selector_(
          objects_, layout_, gripper_.tip_beyond_tcp,
          [this](const Eigen::Isometry3d& T_world_tcp) { return reach(T_world_tcp); }, selection) {}

std::optional<JointVector> RobotKnowledge::reach(const Eigen::Isometry3d& T_world_tcp) const {
  const IkResult result = kinematics_.solve(T_world_tcp, layout_.overview);
  if (!result) return std::nullopt;
  return result->q;
}

RobotSkills RobotKnowledge::make_skills(Robot& robot, Perception* perception,
                                        const SkillOptions& options) const {
  return RobotSkills({robot, perception, arm_, kinematics_, planner_, gripper_, layout_, objects_},
                     options);
}

}  // namespace binpick
