#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace binpick {

/// u = (p_u, n_u), ||n_u|| = 1.
struct OrientedPoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();
  Eigen::Vector3f n = Eigen::Vector3f::UnitZ();
};

/// f_2 .. f_4 of an oriented point pair, rad. f_1, the distance, is fixed by the pair width.
struct PairDescriptor {
  float normals;  ///< f_2, between n_u and n_v
  float first;    ///< f_3, between n_u and p_v - p_u
  float second;   ///< f_4, between n_v and p_u - p_v
};

/// The angle between two unit vectors.
[[nodiscard]] inline float angle_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::clamp(a.dot(b), -1.0f, 1.0f));
}

/// f(u, v) without its first component. IJRR 2012, eq. (1). Invariant under rigid motion.
[[nodiscard]] inline PairDescriptor pair_descriptor(const OrientedPoint& u,
                                                    const OrientedPoint& v) {
  const Eigen::Vector3f direction = (v.p - u.p).normalized();
  return {angle_between(u.n, v.n), angle_between(u.n, direction), angle_between(v.n, -direction)};
}

/// The local frame F_uv of a pair. IJRR 2012, eq. (3). Nothing when the pair does not fix a frame:
/// opposite normals, or normals along the line between the points.
[[nodiscard]] inline std::optional<Eigen::Isometry3f> pair_frame(const OrientedPoint& u,
                                                                 const OrientedPoint& v) {
  constexpr float kLeastSine = 0.05f;
  const Eigen::Vector3f p_uv = v.p - u.p;
  const float length = p_uv.norm();
  if (!(length > 0.0f)) return std::nullopt;
  const Eigen::Vector3f along = p_uv / length;
  const Eigen::Vector3f n_uv = u.n + v.n;
  const Eigen::Vector3f across = along.cross(n_uv);
  const float sine = across.norm();
  if (!(sine > kLeastSine)) return std::nullopt;
  Eigen::Isometry3f frame = Eigen::Isometry3f::Identity();
  frame.linear().col(0) = across / sine;
  frame.linear().col(1) = along;
  frame.linear().col(2) = frame.linear().col(0).cross(along);
  frame.translation() = 0.5f * (u.p + v.p);
  return frame;
}

/// Whether both points seem to lie in one plane: such pairs fit any other pair of any flat face.
[[nodiscard]] inline bool is_coplanar(const PairDescriptor& f) {
  constexpr float kParallel = 0.26f;  // 15 deg
  constexpr float kRightAngle = 1.5707964f;
  return f.normals < kParallel && std::abs(f.first - kRightAngle) < kParallel &&
         std::abs(f.second - kRightAngle) < kParallel;
}

}  // namespace binpick
