#include "control/transfer_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace binpick {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegrees = kPi / 180.0;
constexpr double kCheckStep = 0.04;  // rad: the tool moves less than 4 cm in between

double distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b) noexcept {
  const Eigen::Vector3d along = b - a;
  const double length = std::max(along.squaredNorm(), 1e-18);
  const double t = std::clamp((p - a).dot(along) / length, 0.0, 1.0);
  return (a + t * along - p).norm();
}

/// A posture near `seed` without change of branch.
IkOptions nearby() noexcept {
  IkOptions options;
  options.continuity = 2.0;
  options.max_step = 1.0;
  return options;
}

}  // namespace

TransferPlanner::TransferPlanner(const ArmModel& model, const InverseKinematics& kinematics,
                                 const CellLayout& layout, const TransferOptions& options)
    : model_(model),
      kinematics_(kinematics),
      layout_(layout),
      options_(options),
      arm_(model, layout, options.arm),
      turn_sign_(model.jacobian(JointVector::Zero())(5, 0) > 0.0 ? 1.0 : -1.0) {}

TransferPlanner TransferPlanner::over_pile(double height) const {
  TransferOptions options = options_;
  options.arm.pile_height = height;
  return TransferPlanner(model_, kinematics_, layout_, options);
}

double TransferPlanner::clearance(const JointVector& q) const noexcept {
  // The gripper's fingers and housing come close to the table by purpose; the rest does not.
  return std::min(arm_.to_itself(q), arm_.to_cell(q));
}

bool TransferPlanner::clear(const JointVector& q) const noexcept {
  return clearance(q) >= options_.margin;
}

double TransferPlanner::azimuth(const JointVector& q) const noexcept {
  const Eigen::Vector3d p =
      model_.T_world_base().inverse() * model_.forward_kinematics(q).translation();
  return std::atan2(p.y(), p.x());
}

JointVector TransferPlanner::turned(const JointVector& q, double angle) const noexcept {
  JointVector result = q;
  result[0] += turn_sign_ * angle;
  return result;
}

bool TransferPlanner::allowed(const JointVector& q, const Bounds& bounds) const noexcept {
  if (!(clearance(q) >= bounds.clearance)) return false;
  const Eigen::Vector3d p = model_.forward_kinematics(q).translation();
  if (p.z() >= layout_.transfer_height - options_.height_tolerance) return true;
  const auto inside = [&](const Column& column) {
    return distance_to_segment(p, column.foot, column.head) <= options_.column_radius;
  };
  return inside(bounds.start) || inside(bounds.goal);
}

bool TransferPlanner::allowed(const Path& path, const Bounds& bounds) const noexcept {
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const JointVector step = path[k + 1] - path[k];
    const int checks =
        std::max(1, static_cast<int>(std::ceil(step.cwiseAbs().maxCoeff() / kCheckStep)));
    for (int i = 0; i <= checks; ++i) {
      const double s = static_cast<double>(i) / checks;
      if (!allowed(JointVector(path[k] + s * step), bounds)) return false;
    }
  }
  return true;
}

bool TransferPlanner::rise(Path& path, const Eigen::Isometry3d& from,
                           const Eigen::Isometry3d& to) const {
  const JointVector q_from = path.back();
  const IkResult up = kinematics_.solve(to, q_from, nearby());
  if (!up) return false;
  const Eigen::Vector3d middle = model_.forward_kinematics(0.5 * (q_from + up->q)).translation();
  const double bulge = distance_to_segment(middle, from.translation(), to.translation());
  // A straight line in joint space bulges with the square of its length: halve it if need be.
  constexpr double kShortest = 0.02;
  if (bulge > 0.5 * options_.column_radius &&
      (to.translation() - from.translation()).norm() > kShortest) {
    Eigen::Isometry3d halfway = from;
    halfway.translation() = 0.5 * (from.translation() + to.translation());
    return rise(path, from, halfway) && rise(path, halfway, to);
  }
  path.push_back(up->q);
  return true;
}

std::optional<TransferPlanner::Column> TransferPlanner::column(const JointVector& foot) const {
  const Eigen::Isometry3d T_world_foot = model_.forward_kinematics(foot);
  const Eigen::Vector3d p_foot = T_world_foot.translation();
  Column column{p_foot, p_foot, {foot}};
  if (p_foot.z() >= layout_.transfer_height - options_.height_tolerance) return column;

  Eigen::Vector3d inward = model_.T_world_base().translation() - p_foot;
  inward.z() = 0.0;
  inward.normalize();
  constexpr double kRetreatStep = 0.03;
  for (double retreat = 0.0; retreat <= options_.max_retreat; retreat += kRetreatStep) {
    Eigen::Isometry3d T_world_head = T_world_foot;
    T_world_head.translation() += retreat * inward;
    T_world_head.translation().z() = layout_.transfer_height + options_.height_tolerance;
    column.head = T_world_head.translation();
    column.rising.assign(1, foot);
    if (rise(column.rising, T_world_foot, T_world_head)) return column;
  }
  return std::nullopt;
}

std::optional<TransferPlanner::Path> TransferPlanner::travel(const JointVector& from,
                                                             const JointVector& to,
                                                             const Bounds& bounds) const {
  if (const Path direct{from, to}; allowed(direct, bounds)) return direct;

  // Turn about joint 1 alone with the tool tucked in: no height, no self-clearance changes.
  const double turn = std::remainder(azimuth(to) - azimuth(from), 2.0 * kPi);
  const double base_height = model_.T_world_base().translation().z();
  const std::array<double, 3> radii{0.50, 0.42, 0.58};
  const std::array<double, 3> lifts{0.05, 0.15, 0.0};
  for (const double radius : radii) {
    for (const double lift : lifts) {
      const double at = azimuth(from);
      Eigen::Isometry3d T_world_tucked = model_.forward_kinematics(from);
      const Eigen::Vector3d p_base(radius * std::cos(at), radius * std::sin(at), 0.0);
      T_world_tucked.translation() = model_.T_world_base() * p_base;
      T_world_tucked.translation().z() =
          std::max(layout_.transfer_height + options_.height_tolerance + lift, base_height + 0.2);
      const IkResult tucked = kinematics_.solve(T_world_tucked, from, nearby());
      if (!tucked) continue;
      for (const double angle : {turn, turn - std::copysign(2.0 * kPi, turn)}) {
        const JointVector q_turned = turned(tucked->q, angle);
        if (!model_.limits().contains(q_turned)) continue;
        const Path path{from, tucked->q, q_turned, to};
        if (allowed(path, bounds)) return path;
      }
    }
  }
  return std::nullopt;
}

std::optional<TransferPlanner::Path> TransferPlanner::plan(const JointVector& from,
                                                           const JointVector& to) const {
  if (!from.allFinite() || !model_.limits().contains(to) || !clear(to)) return std::nullopt;
  const std::optional<Column> start = column(from);
  const std::optional<Column> goal = column(to);
  if (!start || !goal) return std::nullopt;

  constexpr double kForgiven = 1e-3;  // m that a crowded start may lose at most
  const Bounds bounds{*start, *goal, std::min(options_.margin, clearance(from) - kForgiven)};
  const std::optional<Path> middle = travel(start->rising.back(), goal->rising.back(), bounds);
  if (!middle) return std::nullopt;
  Path path(start->rising.begin(), start->rising.end() - 1);
  path.insert(path.end(), middle->begin(), middle->end());
  path.insert(path.end(), goal->rising.rbegin() + 1, goal->rising.rend());
  if (!allowed(path, bounds)) return std::nullopt;
  return path;
}

std::optional<TransferPlanner::Path> TransferPlanner::plan(
    const JointVector& from, const Eigen::Isometry3d& T_world_tcp) const {
  const Eigen::Vector3d p = model_.T_world_base().inverse() * T_world_tcp.translation();
  const double turn = std::remainder(std::atan2(p.y(), p.x()) - azimuth(from), 2.0 * kPi);
  std::vector<JointVector> seeds{turned(from, turn), from};
  if (const std::optional<JointVector> ready = top_down_posture(T_world_tcp.translation())) {
    seeds.push_back(*ready);
  }
  for (const JointVector& seed : seeds) {
    const IkResult goal = kinematics_.solve(T_world_tcp, seed);
    if (!goal) return std::nullopt;  // reachability does not depend on the seed
    if (std::optional<Path> path = plan(from, goal->q)) return path;
  }
  return std::nullopt;
}

std::optional<JointVector> TransferPlanner::top_down_posture(const Eigen::Vector3d& p_world) const {
  const Eigen::Vector3d p = model_.T_world_base().inverse() * p_world;
  const double at = std::atan2(p.y(), p.x());
  Eigen::Isometry3d T_world_tcp = model_.T_world_base();
  T_world_tcp.translation() = p_world;
  T_world_tcp.rotate(Eigen::AngleAxisd(at, Eigen::Vector3d::UnitZ()));
  T_world_tcp.rotate(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitY()));
  JointVector seed;
  seed << turn_sign_ * at, -30.0 * kDegrees, 0.0, 90.0 * kDegrees, 0.0, -60.0 * kDegrees, 0.0;
  const IkResult result = kinematics_.solve(T_world_tcp, seed);
  if (!result) return std::nullopt;
  return result->q;
}

}  // namespace binpick
