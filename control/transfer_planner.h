#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "control/arm_clearance.h"
#include "control/arm_model.h"
#include "control/inverse_kinematics.h"
#include "models/cell_layout.h"

namespace binpick {

struct TransferOptions {
  /// Gap that the arm keeps to itself and to the cell, m.
  double margin = 0.02;
  /// While travelling the tool may sink this far below the transfer height, m; the waypoints lie
  /// this far above it. > 0
  double height_tolerance = 0.02;
  /// How far the tool may stray from the line on which it is lifted or lowered, m. > 0
  double column_radius = 0.025;
  /// Where the tool cannot be lifted straight up it is drawn towards the base, at most this far, m.
  double max_retreat = 0.30;
  ArmClearanceOptions arm;
};

/// Plans joint-space paths between postures over the table: lift straight up, turn round the base,
/// come down. Below the layout's transfer height the tool moves only in two columns, over the start
/// and over the goal; the straight joint-space lines between the waypoints are checked every 0.04
/// rad for the tool's height, for the columns, and by capsules against the arm itself, the table,
/// the bins and the pick region (ArmClearance). Posture changes stay continuous: every waypoint is
/// sought near the one before. Deterministic. Immutable: safe to share between threads.
class TransferPlanner {
 public:
  using Path = std::vector<JointVector>;

  TransferPlanner(const ArmModel& model, const InverseKinematics& kinematics,
                  const CellLayout& layout, const TransferOptions& options = {});

  /// The same planner over a pick region in which nothing stands higher than `height` above the
  /// table, m: nearer to the base the arm reaches low poses only with the forearm low, too.
  [[nodiscard]] TransferPlanner over_pile(double height) const;

  /// Waypoints from `from` to `to`, both included, for a JointTrajectory. Empty if there is no such
  /// path. A start that is itself too close to something is forgiven as long as the path does not
  /// come closer; a goal is not. Some milliseconds at most.
  [[nodiscard]] std::optional<Path> plan(const JointVector& from, const JointVector& to) const;

  /// The same to a pose of the tool; the posture is chosen near the one that turning joint 1 would
  /// give, elbow up.
  [[nodiscard]] std::optional<Path> plan(const JointVector& from,
                                         const Eigen::Isometry3d& T_world_tcp) const;

  /// A comfortable posture with the tool at `p_world` pointing straight down, x towards the base,
  /// elbow up. Exists for the tool at the height of grasps 0.40 to 0.75 m from the base axis.
  [[nodiscard]] std::optional<JointVector> top_down_posture(const Eigen::Vector3d& p_world) const;

  /// Whether the arm at `q` keeps the margin to itself and the cell.
  [[nodiscard]] bool clear(const JointVector& q) const noexcept;

 private:
  /// The line on which the tool rises from a low posture; a point where the posture is high.
  struct Column {
    Eigen::Vector3d foot;
    Eigen::Vector3d head;
    Path rising;  ///< from the given posture to the one at the head, both included
  };
  struct Bounds {
    const Column& start;
    const Column& goal;
    double clearance;  ///< wanted gap, m
  };

  [[nodiscard]] double clearance(const JointVector& q) const noexcept;
  [[nodiscard]] std::optional<Column> column(const JointVector& foot) const;
  [[nodiscard]] bool rise(Path& path, const Eigen::Isometry3d& from,
                          const Eigen::Isometry3d& to) const;
  [[nodiscard]] std::optional<Path> travel(const JointVector& from, const JointVector& to,
                                           const Bounds& bounds) const;
  [[nodiscard]] bool allowed(const JointVector& q, const Bounds& bounds) const noexcept;
  [[nodiscard]] bool allowed(const Path& path, const Bounds& bounds) const noexcept;
  [[nodiscard]] double azimuth(const JointVector& q) const noexcept;
  [[nodiscard]] JointVector turned(const JointVector& q, double angle) const noexcept;

  ArmModel model_;
  InverseKinematics kinematics_;
  CellLayout layout_;
  TransferOptions options_;
  ArmClearance arm_;
  double turn_sign_;  // of joint 1's axis against the world's z axis
};

}  // namespace binpick
