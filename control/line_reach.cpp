#include "control/line_reach.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr double kStep = 0.02;      // m
constexpr double kTurn = 0.1;       // rad
constexpr double kJointStep = 0.5;  // rad
constexpr int kMostPoints = 200;    // 4 m, or three turns

}  // namespace

std::optional<IkFailure> line_failure(const InverseKinematics& kinematics,
                                      const Eigen::Isometry3d& T_world_start,
                                      const Eigen::Isometry3d& T_world_goal,
                                      const JointVector& q) noexcept {
  const Eigen::Vector3d way = T_world_goal.translation() - T_world_start.translation();
  const Eigen::AngleAxisd turn(
      Eigen::Matrix3d(T_world_goal.linear() * T_world_start.linear().transpose()));
  const double wanted = std::ceil(std::max(way.norm() / kStep, turn.angle() / kTurn));
  const int points = static_cast<int>(std::clamp(wanted, 1.0, double{kMostPoints}));
  IkOptions options;
  options.min_margin = 0.0;
  options.continuity = 2.0;
  options.max_step = kJointStep;
  JointVector posture = q;
  for (int i = 1; i <= points; ++i) {
    const double share = static_cast<double>(i) / points;
    Eigen::Isometry3d T = T_world_start;
    T.translation() += share * way;
    T.linear() = Eigen::AngleAxisd(share * turn.angle(), turn.axis()) * T_world_start.linear();
    const IkResult found = kinematics.solve(T, posture, options);
    if (!found) return found.failure();
    posture = found->q;
  }
  return std::nullopt;
}

}  // namespace binpick
