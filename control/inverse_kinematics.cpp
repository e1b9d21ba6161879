#include "control/inverse_kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kBranches = 8;
constexpr int kMaxSamples = 720;
constexpr int kElbow = 3;

double wrapped(double angle) noexcept { return std::remainder(angle, 2.0 * kPi); }

/// An angle within (-pi, pi], half a turn on.
double opposite(double angle) noexcept { return angle > 0.0 ? angle - kPi : angle + kPi; }

Eigen::Matrix3d about_y(double angle) noexcept {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Eigen::Matrix3d R;
  R << c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c;
  return R;
}

/// Both solutions (a, b, c) of R = Rz(a) Ry(b) Rz(c): first the one with sin(b) >= 0.
struct ZyzAngles {
  explicit ZyzAngles(const Eigen::Matrix3d& R, double reference) noexcept {
    // Near sin(b) = 0 only a + c is defined, and `a` is the reference. b and c are computed with a
    // already removed, so that an ill-determined a costs no accuracy.
    const double sin_b = std::sqrt(R(0, 2) * R(0, 2) + R(1, 2) * R(1, 2));
    singular = sin_b <= 1e-10;
    const double ca = singular ? std::cos(reference) : R(0, 2) / sin_b;
    const double sa = singular ? std::sin(reference) : R(1, 2) / sin_b;
    const double sin_c = -sa * R(0, 0) + ca * R(1, 0);
    const double cos_c = -sa * R(0, 1) + ca * R(1, 1);
    const double a = singular ? reference : std::atan2(sa, ca);
    upright = {a, std::atan2(ca * R(0, 2) + sa * R(1, 2), R(2, 2)), std::atan2(sin_c, cos_c)};
    flipped = singular ? upright
                       : Eigen::Vector3d(opposite(upright[0]), -upright[1], opposite(upright[2]));
  }

  Eigen::Vector3d upright;
  Eigen::Vector3d flipped;
  bool singular;
};

/// The direction from which swivel angles are counted: normal to `direction`, as upright as can be.
Eigen::Vector3d swivel_reference(const Eigen::Vector3d& direction) noexcept {
  Eigen::Vector3d upright = Eigen::Vector3d::UnitZ() - direction.z() * direction;
  if (upright.norm() < 1e-6) {
    upright = Eigen::Vector3d::UnitX() - direction.x() * direction;
  }
  return upright.normalized();
}

}  // namespace

std::string_view to_string(IkFailure failure) noexcept {
  switch (failure) {
    case IkFailure::kTooFar:
      return "too far from the shoulder";
    case IkFailure::kTooClose:
      return "too close to the shoulder";
    case IkFailure::kJointLimits:
      return "joint limits";
    case IkFailure::kFarFromSeed:
      return "too far from the present posture";
  }
  return "unknown";
}

/// What a pose fixes, whatever the swivel. Base frame.
struct InverseKinematics::ArmPlane {
  Eigen::Matrix3d R_hand;       // the rotation that all seven joints produce
  Eigen::Vector3d direction;    // unit, shoulder to wrist
  Eigen::Vector3d reference;    // unit, elbow side at swivel zero
  double distance = 0.0;        // shoulder to wrist, m
  double shoulder_angle = 0.0;  // between `direction` and the upper arm
  double elbow_angle = 0.0;     // between upper arm and forearm, [0, pi]; zero when stretched
  Eigen::Matrix3d R_elbow;      // by elbow_angle about y
};

InverseKinematics::InverseKinematics(const ArmModel& model)
    : T_world_base_(model.T_world_base()), limits_(model.limits()) {
  const JointVector zero = JointVector::Zero();
  const Eigen::Isometry3d T_base_world = T_world_base_.inverse();
  const std::array<Eigen::Isometry3d, kArmJoints + 1> poses = model.link_poses(zero);
  const Jacobian J = model.jacobian(zero);
  std::array<double, kArmJoints> height{};
  for (int i = 0; i < kArmJoints; ++i) {
    const std::size_t joint = static_cast<std::size_t>(i);
    const Eigen::Vector3d axis = T_base_world.linear() * J.col(i).tail<3>();
    const Eigen::Vector3d p = T_base_world * poses[joint + 1].translation();
    const double along = i % 2 == 0 ? axis.z() : axis.y();
    // An axis parallel to y may have its origin anywhere along itself.
    const double off_axis = i % 2 == 0 ? p.head<2>().norm() : std::abs(p.x());
    if (std::abs(std::abs(along) - 1.0) > 1e-9 || off_axis > 1e-9) {
      throw InputError(fmt::format(
          "joint {}: the closed-form inverse kinematics needs a spherical-revolute-spherical arm, "
          "at zero position with axes 1, 3, 5, 7 along the base's z axis and 2, 4, 6 parallel to y "
          "through it; give the arm this geometry",
          i + 1));
    }
    sign_[i] = along > 0.0 ? 1.0 : -1.0;
    height[joint] = p.z();
  }
  shoulder_height_ = height[1];
  upper_arm_ = height[3] - height[1];
  forearm_ = height[5] - height[3];
  if (upper_arm_ <= 0.0 || forearm_ <= 0.0) {
    throw InputError(
        "joints 2, 4, 6: the elbow must lie above the shoulder and the wrist above the "
        "elbow when all joints are at zero");
  }
  const Eigen::Isometry3d T_base_tcp = T_base_world * model.forward_kinematics(zero);
  R_base_tcp_zero_ = T_base_tcp.linear();
  p_tcp_wrist_ = T_base_tcp.inverse() * Eigen::Vector3d(0.0, 0.0, height[5]);

  const double bend =
      std::min(kPi, std::max(std::abs(limits_.lower[kElbow]), std::abs(limits_.upper[kElbow])));
  const double straight = upper_arm_ + forearm_;
  reach_.low =
      std::sqrt(straight * straight - 2.0 * upper_arm_ * forearm_ * (1.0 - std::cos(bend)));
  reach_.high = straight;
}

std::optional<IkFailure> InverseKinematics::out_of_reach(double distance) const noexcept {
  if (distance > reach_.high) return IkFailure::kTooFar;
  if (distance < reach_.low) return IkFailure::kTooClose;
  return std::nullopt;
}

InverseKinematics::ArmPlane InverseKinematics::arm_plane(
    const Eigen::Isometry3d& T_world_tcp) const noexcept {
  const Eigen::Isometry3d T_base_tcp = T_world_base_.inverse() * T_world_tcp;
  const Eigen::Vector3d p_wrist = T_base_tcp * p_tcp_wrist_;
  const Eigen::Vector3d to_wrist = p_wrist - Eigen::Vector3d(0.0, 0.0, shoulder_height_);
  const double a = upper_arm_;
  const double b = forearm_;

  ArmPlane plane;
  plane.R_hand = T_base_tcp.linear() * R_base_tcp_zero_.transpose();
  plane.distance = to_wrist.norm();
  plane.direction = to_wrist / std::max(plane.distance, 1e-12);
  plane.reference = swivel_reference(plane.direction);
  // Half-angle form of the law of cosines: accurate for the stretched arm too.
  const double d = plane.distance;
  const double stretch = std::max(0.0, (a + b - d) * (a + b + d));
  const double fold = std::max(0.0, (d - (a - b)) * (d + (a - b)));
  plane.elbow_angle = 2.0 * std::atan2(std::sqrt(stretch), std::sqrt(fold));
  plane.shoulder_angle =
      std::atan2(b * std::sin(plane.elbow_angle), a + b * std::cos(plane.elbow_angle));
  plane.R_elbow = about_y(plane.elbow_angle);
  return plane;
}

InverseKinematics::Postures InverseKinematics::postures(
    const ArmPlane& plane, double swivel, const JointVector& reference) const noexcept {
  const Eigen::Vector3d side = std::cos(swivel) * plane.reference +
                               std::sin(swivel) * plane.direction.cross(plane.reference);
  const double c = std::cos(plane.shoulder_angle);
  const double s = std::sin(plane.shoulder_angle);
  // Upper arm: z along it, x towards the wrist; defined for the stretched arm.
  Eigen::Matrix3d R_upper;
  R_upper.col(2) = c * plane.direction + s * side;
  R_upper.col(0) = s * plane.direction - c * side;
  R_upper.col(1) = R_upper.col(2).cross(R_upper.col(0));
  const Eigen::Matrix3d R_forearm = R_upper.lazyProduct(plane.R_elbow);
  const Eigen::Matrix3d R_wrist = R_forearm.transpose().lazyProduct(plane.R_hand);
  const double shoulder_reference = sign_[0] * reference[0];
  const double wrist_reference = sign_[4] * reference[4];

  Postures result;
  const auto fill = [&](std::size_t bend, const ZyzAngles& shoulder, double elbow,
                        const ZyzAngles& wrist) {
    for (std::size_t branch = bend; branch < kBranches; branch += 2) {
      const Eigen::Vector3d& upper = (branch & 2) == 0 ? shoulder.upright : shoulder.flipped;
      const Eigen::Vector3d& hand = (branch & 4) == 0 ? wrist.upright : wrist.flipped;
      result[branch] << upper, elbow, hand;
      result[branch] = result[branch].cwiseProduct(sign_);
    }
  };
  ZyzAngles shoulder(R_upper, shoulder_reference);
  ZyzAngles wrist(R_wrist, wrist_reference);
  fill(0, shoulder, plane.elbow_angle, wrist);

  // Bent the other way, upper arm and forearm turn by half a turn about themselves:
  // Rz(pi) Ry(-b) = Ry(b) Rz(pi).
  if (shoulder.singular) {
    R_upper.leftCols<2>() = -R_upper.leftCols<2>();
    shoulder = ZyzAngles(R_upper, shoulder_reference);
  } else {
    shoulder.upright[2] = opposite(shoulder.upright[2]);
    shoulder.flipped[2] = opposite(shoulder.flipped[2]);
  }
  if (wrist.singular) {
    Eigen::Matrix3d R_turned = R_wrist;
    R_turned.topRows<2>() = -R_turned.topRows<2>();
    wrist = ZyzAngles(R_turned, wrist_reference);
  } else {
    std::swap(wrist.upright[0], wrist.flipped[0]);
  }
  fill(1, shoulder, -plane.elbow_angle, wrist);
  return result;
}

double InverseKinematics::margin(const JointVector& q) const noexcept {
  const Eigen::Array<double, kArmJoints, 1> nearest =
      (q - limits_.lower).cwiseMin(limits_.upper - q).array();
  return (2.0 * nearest / (limits_.upper - limits_.lower).array()).minCoeff();
}

double InverseKinematics::free_margin(const JointVector& q) const noexcept {
  JointVector centred = q;
  centred[kElbow] = 0.5 * (limits_.lower[kElbow] + limits_.upper[kElbow]);
  return margin(centred);
}

double InverseKinematics::swivel(const JointVector& q) const noexcept {
  const double c1 = std::cos(sign_[0] * q[0]);
  const double s1 = std::sin(sign_[0] * q[0]);
  const double c3 = std::cos(sign_[2] * q[2]);
  const double s3 = std::sin(sign_[2] * q[2]);
  Eigen::Matrix3d R_1;
  R_1 << c1, -s1, 0.0, s1, c1, 0.0, 0.0, 0.0, 1.0;
  Eigen::Matrix3d R_3;
  R_3 << c3, -s3, 0.0, s3, c3, 0.0, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d R_upper = R_1 * about_y(sign_[1] * q[1]) * R_3;
  const double bend = sign_[kElbow] * q[kElbow];
  const Eigen::Vector3d to_wrist =
      upper_arm_ * R_upper.col(2) + forearm_ * (R_upper * about_y(bend).col(2));
  const Eigen::Vector3d direction = to_wrist.normalized();
  // The inverse of the upper arm's axes in posture(); defined for the stretched arm too.
  const Eigen::Vector3d x = (bend < 0.0 ? -1.0 : 1.0) * R_upper.col(0);
  const Eigen::Vector3d z = R_upper.col(2);
  const Eigen::Vector3d side = x.dot(direction) * z - z.dot(direction) * x;
  const Eigen::Vector3d reference = swivel_reference(direction);
  return std::atan2(direction.cross(reference).dot(side), reference.dot(side));
}

IkBranches InverseKinematics::branches(const Eigen::Isometry3d& T_world_tcp,
                                       double swivel) const noexcept {
  IkBranches found;
  const ArmPlane plane = arm_plane(T_world_tcp);
  if (out_of_reach(plane.distance)) return found;
  for (const JointVector& q : postures(plane, swivel, JointVector::Zero())) {
    if (limits_.contains(q)) found.push_back({q, wrapped(swivel), margin(q)});
  }
  return found;
}

double InverseKinematics::refine(const ArmPlane& plane, std::size_t branch, double swivel,
                                 double half_width, const JointVector& reference) const noexcept {
  // Golden-section search for the largest margin.
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSteps = 40;
  const auto value = [&](double psi) { return margin(postures(plane, psi, reference)[branch]); };
  double low = swivel - half_width;
  double high = swivel + half_width;
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double value_left = value(left);
  double value_right = value(right);
  for (int step = 0; step < kSteps; ++step) {
    if (value_left > value_right) {
      high = right;
      right = left;
      value_right = value_left;
      left = high - kGolden * (high - low);
      value_left = value(left);
    } else {
      low = left;
      left = right;
      value_left = value_right;
      right = low + kGolden * (high - low);
      value_right = value(right);
    }
  }
  return value_left > value_right ? left : right;
}

IkResult InverseKinematics::solve(const Eigen::Isometry3d& T_world_tcp, const JointVector& seed,
                                  const IkOptions& options) const noexcept {
  const ArmPlane plane = arm_plane(T_world_tcp);
  if (const std::optional<IkFailure> failure = out_of_reach(plane.distance)) return *failure;

  const int samples = std::clamp(options.swivel_samples, 8, kMaxSamples);
  const double step = 2.0 * kPi / samples;
  const double first = swivel(seed);
  bool posture_exists = false;
  double best_score = -std::numeric_limits<double>::infinity();
  IkSolution best;
  const auto consider = [&](const JointVector& q, double psi) {
    const double all = margin(q);
    if (all < options.min_margin) return all;
    posture_exists = true;
    const double distance = (q - seed).cwiseAbs().maxCoeff();
    if (distance > options.max_step) return all;
    const double score = free_margin(q) - options.continuity * distance / kPi -
                         options.elbow_up * 0.5 * (1.0 - std::cos(psi));
    if (score > best_score) {
      best_score = score;
      best = {q, wrapped(psi), all};
    }
    return all;
  };

  std::array<std::array<double, kMaxSamples>, kBranches> margins;
  for (int k = 0; k < samples; ++k) {
    const double psi = first + k * step;
    const Postures all = postures(plane, psi, seed);
    for (std::size_t branch = 0; branch < kBranches; ++branch) {
      margins[branch][std::size_t(k)] = consider(all[branch], psi);
    }
  }
  if (!posture_exists) {
    for (std::size_t branch = 0; branch < kBranches; ++branch) {
      const std::array<double, kMaxSamples>& of_branch = margins[branch];
      for (int k = 0; k < samples; ++k) {
        const double before = of_branch[std::size_t((k + samples - 1) % samples)];
        const double after = of_branch[std::size_t((k + 1) % samples)];
        const double here = of_branch[std::size_t(k)];
        if (here < before || here < after) continue;
        const double psi = refine(plane, branch, first + k * step, step, seed);
        consider(postures(plane, psi, seed)[branch], psi);
      }
    }
  }
  if (best_score > -std::numeric_limits<double>::infinity()) return best;
  return posture_exists ? IkFailure::kFarFromSeed : IkFailure::kJointLimits;
}

}  // namespace binpick
