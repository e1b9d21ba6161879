#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "control/arm_model.h"

namespace binpick {

/// A joint position that reaches a wanted pose.
struct IkSolution {
  JointVector q = JointVector::Zero();  ///< rad
  double swivel = 0.0;                  ///< of the elbow, rad, in (-pi, pi]
  /// Distance to the nearest joint limit as a fraction of that joint's half range: 1 in the middle
  /// of all ranges, 0 at a limit, negative beyond it.
  double margin = 0.0;
};

/// The solutions for one pose and one swivel angle: at most eight, without heap.
class IkBranches {
 public:
  void push_back(const IkSolution& solution) noexcept { solutions_[size_++] = solution; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] const IkSolution* begin() const noexcept { return solutions_.data(); }
  [[nodiscard]] const IkSolution* end() const noexcept { return solutions_.data() + size_; }
  [[nodiscard]] const IkSolution& operator[](std::size_t i) const noexcept { return solutions_[i]; }

 private:
  std::array<IkSolution, 8> solutions_;
  std::size_t size_ = 0;
};

struct IkOptions {
  /// Swivel angles tried, evenly spread and including the seed's own. More find a better elbow
  /// position at proportional cost. >= 8.
  int swivel_samples = 72;
  /// A solution must keep this margin (see IkSolution) to every joint limit. [0, 1)
  double min_margin = 0.01;
  /// Weight of staying near the seed (largest joint difference over pi) against the margin.
  /// 0: the best posture wherever the arm stands now; 2: hardly leaves the seed's branch.
  double continuity = 0.5;
  /// Weight of a raised elbow: a hanging elbow costs this much margin.
  double elbow_up = 0.2;
  /// No joint may differ more than this from the seed, rad. Two turns: no constraint.
  double max_step = 12.6;
};

enum class IkFailure {
  kTooFar,       ///< the wrist lies outside the reach of the stretched arm
  kTooClose,     ///< the wrist lies nearer to the shoulder than the folded arm can come
  kJointLimits,  ///< every posture violates a joint limit (or the wanted margin to it)
  kFarFromSeed,  ///< postures exist, none within `max_step` of the seed
};
[[nodiscard]] std::string_view to_string(IkFailure failure) noexcept;

/// A solution, or why there is none.
class IkResult {
 public:
  IkResult(const IkSolution& solution) noexcept
      : solution_(solution) {}                                 // NOLINT: a value or why not
  IkResult(IkFailure failure) noexcept : failure_(failure) {}  // NOLINT

  [[nodiscard]] explicit operator bool() const noexcept { return solution_.has_value(); }
  [[nodiscard]] const IkSolution& operator*() const noexcept { return *solution_; }
  [[nodiscard]] const IkSolution* operator->() const noexcept { return &*solution_; }
  /// Only when there is no solution.
  [[nodiscard]] IkFailure failure() const noexcept { return failure_; }

 private:
  std::optional<IkSolution> solution_;
  IkFailure failure_ = IkFailure::kJointLimits;
};

/// Closed-form inverse kinematics of a spherical-revolute-spherical arm: shoulder S (axes 1-3),
/// elbow E (axis 4), wrist W (axes 5-7). The pose fixes W and the triangle S-E-W; the remaining
/// freedom is the swivel angle, the rotation of E about the line SW. Swivel 0 is the highest elbow;
/// it grows right-handedly about the direction S to W. Where SW is vertical it is counted from the
/// base's x axis. For each swivel there are two elbow bends, two shoulders and two wrists.
/// Joint positions are sought in (-pi, pi]. Immutable: safe to share between threads.
class InverseKinematics {
 public:
  /// @throws InputError if the arm is not of this kind: with all joints at zero, the odd axes along
  /// the base's z axis, the even ones parallel to y, all through the base's z axis.
  explicit InverseKinematics(const ArmModel& model);

  /// All solutions with this swivel angle within the joint limits. Empty if there are none.
  [[nodiscard]] IkBranches branches(const Eigen::Isometry3d& T_world_tcp,
                                    double swivel) const noexcept;

  /// The best posture: over sampled swivel angles and all branches, the largest margin to the
  /// joint limits, less the penalties of `options`. Joint 4 counts only against its limit there,
  /// because the pose alone fixes its bend. If no sample is within the limits, the swivel
  /// is refined about the least violations, so that narrow feasible intervals are found as well.
  /// About 0.2 ms. Allocates nothing.
  [[nodiscard]] IkResult solve(const Eigen::Isometry3d& T_world_tcp, const JointVector& seed,
                               const IkOptions& options = {}) const noexcept;

  /// The swivel angle of a posture.
  [[nodiscard]] double swivel(const JointVector& q) const noexcept;
  /// Margin to the joint limits, see IkSolution.
  [[nodiscard]] double margin(const JointVector& q) const noexcept;

  /// Distances from shoulder to wrist that the elbow's joint limits allow, m.
  [[nodiscard]] const Interval& reach() const noexcept { return reach_; }
  [[nodiscard]] Eigen::Vector3d p_world_shoulder() const noexcept {
    return T_world_base_ * Eigen::Vector3d(0.0, 0.0, shoulder_height_);
  }
  [[nodiscard]] Eigen::Vector3d p_world_wrist(const Eigen::Isometry3d& T_world_tcp) const noexcept {
    return T_world_tcp * p_tcp_wrist_;
  }

 private:
  struct ArmPlane;

  [[nodiscard]] std::optional<IkFailure> out_of_reach(double distance) const noexcept;
  [[nodiscard]] ArmPlane arm_plane(const Eigen::Isometry3d& T_world_tcp) const noexcept;
  /// All branches at a swivel angle, whatever the limits, from one decomposition of the shoulder
  /// and one of the wrist. Bit 0 of the index: elbow, bit 1: shoulder, bit 2: wrist.
  using Postures = std::array<JointVector, 8>;
  [[nodiscard]] Postures postures(const ArmPlane& plane, double swivel,
                                  const JointVector& reference) const noexcept;
  [[nodiscard]] double free_margin(const JointVector& q) const noexcept;
  [[nodiscard]] double refine(const ArmPlane& plane, std::size_t branch, double swivel,
                              double half_width, const JointVector& reference) const noexcept;

  Eigen::Isometry3d T_world_base_;
  JointLimits limits_;
  JointVector sign_;                 // +1 or -1: axis along +z / +y of the base or against it
  Eigen::Matrix3d R_base_tcp_zero_;  // with all joints at zero
  Eigen::Vector3d p_tcp_wrist_;
  double shoulder_height_;
  double upper_arm_;
  double forearm_;
  Interval reach_;
};

}  // namespace binpick
