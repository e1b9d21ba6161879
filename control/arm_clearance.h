#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "control/arm_model.h"
#include "models/cell_layout.h"

namespace binpick {

/// All points within `radius` of the segment from a to b.
struct Capsule {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
  double radius = 0.0;
};

/// Distance between the surfaces of two capsules, m; negative when they overlap.
[[nodiscard]] double distance(const Capsule& first, const Capsule& second) noexcept;

/// Sizes of the capsules round the arm, m.
struct ArmClearanceOptions {
  double column_radius = 0.10;  ///< base to shoulder, the shoulder's hub included
  double upper_arm_radius = 0.08;
  double forearm_radius = 0.08;
  double wrist_radius = 0.07;
  double housing_radius = 0.06;        ///< of the gripper's housing, whose axis is the tool's y
  double housing_half_length = 0.095;  ///< to the housing's end along y
  double finger_radius = 0.02;
  double finger_offset = 0.09;  ///< of a finger from the tool's z axis, jaws opened
  /// Assumed height of what lies in the pick region, above the table.
  double pile_height = 0.22;
};

/// How much room the arm has to itself and to the known parts of the cell: the table, the places
/// up to their rims, the pick region up to the assumed height of a pile. The arm is seven capsules
/// (column, upper arm, forearm, wrist, gripper housing, two fingers). Wrist and gripper are held
/// only against arm and table: their business is over and in bins and piles, and whoever plans the
/// tool's path keeps them out elsewhere. Immutable.
class ArmClearance {
 public:
  static constexpr std::size_t kCapsules = 7;

  ArmClearance(const ArmModel& model, const CellLayout& layout,
               const ArmClearanceOptions& options = {});

  /// Column, upper arm, forearm, wrist, housing, fingers; world.
  [[nodiscard]] std::array<Capsule, kCapsules> capsules(const JointVector& q) const noexcept;

  /// Smallest gap between parts of the arm that are no neighbours, m.
  [[nodiscard]] double to_itself(const JointVector& q) const noexcept;
  /// Smallest height of the upper arm and the forearm above what lies below them, and of wrist and
  /// gripper above the table, m. Along a capsule's axis five points are looked at.
  [[nodiscard]] double to_cell(const JointVector& q) const noexcept;

 private:
  struct Block {
    Eigen::Vector2d low;
    Eigen::Vector2d high;
    double top = 0.0;
  };

  [[nodiscard]] double height_below(const Eigen::Vector3d& p, double radius) const noexcept;

  ArmModel model_;
  ArmClearanceOptions options_;
  double table_height_;
  std::vector<Block> blocks_;
};

}  // namespace binpick
