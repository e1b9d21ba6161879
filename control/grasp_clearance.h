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
  /// `margin` widens fingers and housing on every side, m.
  GraspClearance(const RangeImage& image, const GripperDescription& gripper, double table_height,
                 double margin = 0.003);

  /// Points within the volume that fingers and housing sweep along the approach. Points within
  /// `own_margin` (m) of the target's bounding box are its own and do not count.
  [[nodiscard]] int obstructing_points(const GraspPlan& plan, double own_margin = 0.005) const;

 private:
  [[nodiscard]] bool in_swept_gripper(const Eigen::Vector3d& p_grasp,
                                      double opening) const noexcept;

  std::vector<Eigen::Vector3d> points_world_;
  GripperDescription gripper_;
  double margin_;
};

}  // namespace binpick
