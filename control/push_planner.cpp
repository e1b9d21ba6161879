#include "control/push_planner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace binpick {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kShortest = 0.02;  // m; a shorter push is not worth its time

/// The tool above the table, closed jaws across `direction`, its upper end leaning that way.
Eigen::Matrix3d pushing_orientation(const Eigen::Vector3d& direction, double lean) {
  Eigen::Matrix3d R_world_tcp;
  R_world_tcp.col(2) = -std::sin(lean) * direction - std::cos(lean) * Eigen::Vector3d::UnitZ();
  R_world_tcp.col(1) = Eigen::Vector3d::UnitZ().cross(direction);
  R_world_tcp.col(0) = R_world_tcp.col(1).cross(R_world_tcp.col(2));
  return R_world_tcp;
}

}  // namespace

std::optional<Push> plan_push(const std::vector<Eigen::Vector3d>& surface, const CellLayout& layout,
                              const GripperDescription& gripper,
                              const std::function<bool(const Push&)>& feasible,
                              const PushOptions& options) {
  if (surface.empty()) return std::nullopt;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double top = layout.table_height;
  for (const Eigen::Vector3d& p_world : surface) {
    centre += p_world;
    top = std::max(top, p_world.z());
  }
  centre /= static_cast<double>(surface.size());
  Eigen::Vector3d direction = centre - layout.T_world_base.translation();
  direction.z() = 0.0;
  const double radius = direction.norm();
  direction /= std::max(radius, 1e-9);
  const double gain = std::min(std::abs(options.comfortable_radius - radius), options.longest);
  if (gain < kShortest) return std::nullopt;
  if (radius > options.comfortable_radius) direction = -direction;

  const Eigen::Vector3d sideways = Eigen::Vector3d::UnitZ().cross(direction);
  const double low = layout.table_height + options.tip_height;
  const auto push_at = [&](double tip_z, double lean) {
    // The leaning fingers clear every point in their lane by the margin.
    double back = 0.0;
    for (const Eigen::Vector3d& p_world : surface) {
      if (std::abs(sideways.dot(p_world - centre)) > options.lane) continue;
      const double over = std::max(p_world.z() - tip_z, 0.0) * std::tan(lean);
      back = std::max(back, over - direction.dot(p_world - centre));
    }
    back += options.margin;
    Eigen::Vector3d p_tip = centre - back * direction;
    p_tip.z() = tip_z;

    Push push;
    push.T_world_start.linear() = pushing_orientation(direction, lean);
    const Eigen::Vector3d v_approach = push.T_world_start.linear().col(2);
    push.T_world_start.translation() = p_tip - gripper.tip_beyond_tcp * v_approach;
    push.T_world_before =
        Eigen::Translation3d(-options.approach_distance * v_approach) * push.T_world_start;
    push.T_world_end =
        Eigen::Translation3d((options.margin + gain) * direction) * push.T_world_start;
    return push;
  };
  for (const double tip_z : {low, std::max(low, 0.5 * (layout.table_height + top))}) {
    for (const double lean_deg : {0.0, 10.0, 20.0, 30.0, 40.0, 50.0}) {
      const Push push = push_at(tip_z, lean_deg * kDegree);
      if (feasible(push)) return push;
    }
  }
  return std::nullopt;
}

}  // namespace binpick
