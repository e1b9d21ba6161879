#include "control/arm_clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace binpick {
namespace {

enum Part : std::size_t { kColumn, kUpperArm, kForearm, kWrist, kHousing, kLeft, kRight };

/// Neighbours touch by design; the forearm cannot reach the upper arm within the elbow's limits.
constexpr std::array<std::pair<Part, Part>, 9> kSelfPairs{{{kColumn, kForearm},
                                                           {kColumn, kWrist},
                                                           {kColumn, kHousing},
                                                           {kColumn, kLeft},
                                                           {kColumn, kRight},
                                                           {kUpperArm, kWrist},
                                                           {kUpperArm, kHousing},
                                                           {kUpperArm, kLeft},
                                                           {kUpperArm, kRight}}};

/// Squared distance between two segments (Ericson, Real-Time Collision Detection, 2005, 5.1.9).
double squared_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& c, const Eigen::Vector3d& d) noexcept {
  const Eigen::Vector3d u = b - a;
  const Eigen::Vector3d v = d - c;
  const Eigen::Vector3d w = a - c;
  const double uu = std::max(u.squaredNorm(), 1e-18);
  const double vv = std::max(v.squaredNorm(), 1e-18);
  const double uv = u.dot(v);
  const double uw = u.dot(w);
  const double vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  double s =
      determinant > 1e-12 * uu * vv ? std::clamp((uv * vw - uw * vv) / determinant, 0.0, 1.0) : 0.0;
  const double t = std::clamp((uv * s + vw) / vv, 0.0, 1.0);
  s = std::clamp((uv * t - uw) / uu, 0.0, 1.0);
  return (w + s * u - t * v).squaredNorm();
}

}  // namespace

double distance(const Capsule& first, const Capsule& second) noexcept {
  return std::sqrt(squared_distance(first.a, first.b, second.a, second.b)) - first.radius -
         second.radius;
}

ArmClearance::ArmClearance(const ArmModel& model, const CellLayout& layout,
                           const ArmClearanceOptions& options)
    : model_(model), options_(options), table_height_(layout.table_height) {
  for (const Place& place : layout.places) {
    blocks_.push_back({place.p_world - 0.5 * place.size, place.p_world + 0.5 * place.size,
                       std::max(place.rim_height, place.floor_height)});
  }
  if (!layout.pick_region.isEmpty()) {
    blocks_.push_back(
        {layout.pick_region.min(), layout.pick_region.max(), table_height_ + options.pile_height});
  }
}

std::array<Capsule, ArmClearance::kCapsules> ArmClearance::capsules(
    const JointVector& q) const noexcept {
  const std::array<Eigen::Isometry3d, kArmJoints + 1> poses = model_.link_poses(q);
  const Eigen::Vector3d base = poses[0].translation();
  const Eigen::Vector3d shoulder = poses[2].translation();
  const Eigen::Vector3d elbow = poses[4].translation();
  const Eigen::Vector3d wrist = poses[6].translation();
  const Eigen::Isometry3d T_world_flange = poses[7] * model_.T_link7_flange();
  const Eigen::Isometry3d T_world_tcp = poses[7] * model_.T_link7_tcp();
  const Eigen::Vector3d flange = T_world_flange.translation();
  const Eigen::Vector3d tip = T_world_tcp.translation();
  const Eigen::Vector3d y = T_world_tcp.linear().col(1);
  // The housing fills the upper half between flange and tool centre, the fingers the lower.
  const Eigen::Vector3d housing = flange + 0.25 * (tip - flange);
  const Eigen::Vector3d palm = flange + 0.5 * (tip - flange);
  const Eigen::Vector3d half = (options_.housing_half_length - options_.housing_radius) * y;
  const Eigen::Vector3d aside = options_.finger_offset * y;
  return {{{base, shoulder, options_.column_radius},
           {shoulder, elbow, options_.upper_arm_radius},
           {elbow, wrist, options_.forearm_radius},
           {wrist, flange, options_.wrist_radius},
           {housing - half, housing + half, options_.housing_radius},
           {palm + aside, tip + aside, options_.finger_radius},
           {palm - aside, tip - aside, options_.finger_radius}}};
}

double ArmClearance::to_itself(const JointVector& q) const noexcept {
  const std::array<Capsule, kCapsules> arm = capsules(q);
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& [first, second] : kSelfPairs) {
    smallest = std::min(smallest, distance(arm[first], arm[second]));
  }
  return smallest;
}

double ArmClearance::height_below(const Eigen::Vector3d& p, double radius) const noexcept {
  double height = table_height_;
  for (const Block& block : blocks_) {
    const Eigen::Array2d outside =
        (block.low - p.head<2>()).cwiseMax(p.head<2>() - block.high).array();
    if ((outside < radius).all()) height = std::max(height, block.top);
  }
  return height;
}

double ArmClearance::to_cell(const JointVector& q) const noexcept {
  constexpr int kSteps = 4;
  const std::array<Capsule, kCapsules> arm = capsules(q);
  double smallest = std::numeric_limits<double>::infinity();
  for (const Part part : {kUpperArm, kForearm}) {
    const Capsule& capsule = arm[part];
    for (int k = 0; k <= kSteps; ++k) {
      const Eigen::Vector3d p = capsule.a + (capsule.b - capsule.a) * (double(k) / kSteps);
      smallest = std::min(smallest, p.z() - capsule.radius - height_below(p, capsule.radius));
    }
  }
  for (const Part part : {kWrist, kHousing}) {
    const Capsule& capsule = arm[part];
    smallest =
        std::min(smallest, std::min(capsule.a.z(), capsule.b.z()) - capsule.radius - table_height_);
  }
  // Fingers end in flat pads: a standing finger may touch the table with its tip.
  for (const Part part : {kLeft, kRight}) {
    smallest = std::min(smallest, std::min(arm[part].a.z(), arm[part].b.z()) - table_height_);
  }
  return smallest;
}

}  // namespace binpick
