#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/grasp_selection.h"
#include "models/gripper_description.h"
#include "models/range_image.h"

namespace binpick {

/// Counts the measured scene points that the open gripper would run into on its way to a grasp.
/// The paper's grasp planner looks at the target alone (section 5.1); in a pile the neighbours
/// decide, and the range image shows them whether or not they were recognized.
class GraspClearance {
 public:
  /// `margin` widens fingers and housing on every side, m. Fewer measured points than
  /// `least_points` in the gripper's way are noise.
  GraspClearance(RangeImage image, const GripperDescription& gripper, double table_height,
                 double margin = 0.003, int least_points = 6);

  /// From now on the whole surface of `detection` (world frame) counts as if it had been measured,
  /// save for grasps of that object itself.
  void add_object(const Detection& detection, const ObjectModel& object);

  /// Measured points above the table within `region`.
  [[nodiscard]] std::vector<Eigen::Vector3d> points_within(const Eigen::AlignedBox2d& region) const;

  /// Points within the volume that fingers and housing sweep along the approach. Measured points
  /// within `own_margin` (m) of the target's bounding box are its own and do not count.
  [[nodiscard]] int obstructing_points(const GraspPlan& plan, double own_margin = 0.005) const;

  /// Share of the space that the fingers take up at the grasp of which the image tells nothing,
  /// because it lies in the shadow of what was measured: something may stand there unseen.
  [[nodiscard]] double hidden_share(const GraspPlan& plan) const;

 private:
  [[nodiscard]] bool in_shadow(const Eigen::Vector3d& p_world) const noexcept;
  [[nodiscard]] bool in_swept_gripper(const Eigen::Vector3d& p_grasp,
                                      double opening) const noexcept;

  struct KnownObject {
    Detection detection;
    std::vector<Eigen::Vector3d> points_world;
  };

  RangeImage image_;
  std::vector<Eigen::Vector3d> points_world_;
  std::vector<KnownObject> objects_;
  GripperDescription gripper_;
  double table_height_;
  double margin_;
  int least_points_;
};

}  // namespace binpick
