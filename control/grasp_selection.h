#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "control/manipulation_strategy.h"
#include "models/cell_layout.h"
#include "models/detection.h"
#include "models/object_model.h"

namespace binpick {

/// Parameters of the grasp selection, IJRR 2012, section 5.1.
struct GraspSelectionOptions {
  double alignment_weight = 3.0;                            ///< w1 of eq. (12), per rad
  double wrist_weight = 1.0;                                ///< w2 of eq. (12), per rad
  double max_tilt = 30.0 * 3.14159265358979323846 / 180.0;  ///< phi_z: discarded from here on, rad
  double neutral_wrist = 0.0;      ///< phi_0^wrist of eq. (14): joint 7, rad
  double approach_distance = 0.1;  ///< the grasp is projected this far along v_appr, m
  double tip_clearance = 0.004;    ///< finger tips stay this far above the table, m

  // Beyond the paper; as they are, without effect.
  /// What a miss for certain (miss_probability) adds to the cost of eq. (12).
  double miss_weight = 0.0;
  /// Objects less likely to be there than this come after all others.
  double least_confidence = 0.0;
  /// Strays are looked for, too: known objects on the table that lie outside the pick region and
  /// farther than `place_margin` (m) from every place.
  bool strays = false;
  double place_margin = 0.05;

  [[nodiscard]] static GraspSelectionOptions of(const ManipulationStrategy& strategy) noexcept;
};

/// A grasp of a detected object, ready to be executed.
struct GraspPlan {
  Detection detection;  ///< pose in the world frame
  const ObjectModel* object = nullptr;
  const Grasp* grasp = nullptr;
  Eigen::Isometry3d T_world_grasp = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_pregrasp = Eigen::Isometry3d::Identity();  ///< 0.1 m before the grasp
  JointVector q_pregrasp = JointVector::Zero();
  double tilt = 0.0;   ///< crit_1, eq. (13), rad
  double wrist = 0.0;  ///< crit_2, eq. (14), rad
  double miss = 0.0;   ///< miss_probability
  double cost = 0.0;   ///< eq. (12)
};

/// crit_1, eq. (13): the angle between -v_appr and the world's z axis, rad.
[[nodiscard]] double alignment_criterion(const Eigen::Isometry3d& T_world_grasp) noexcept;

/// crit_2, eq. (14): the distance between the wrist angle that the grasp requires and the neutral
/// one, rad.
[[nodiscard]] double wrist_criterion(double required_wrist, double neutral_wrist) noexcept;

/// The probability that a finger comes down on the object instead of beside it: that the error of
/// the object's pose moves the middle between the pads, along the jaws, by more than the room that
/// the pre-opening leaves on either side. Normal errors, Detection::covariance to first order; 0
/// without a covariance.
[[nodiscard]] double miss_probability(const Detection& detection, const Grasp& grasp);

/// Chooses what to grasp next, and how: the uppermost object (highest centre of mass), and of its
/// stored grasps the cheapest feasible one (eqs. 12-14); if it has none, the next lower object.
/// The paper leaves open what else makes a grasp feasible. Here: the arm reaches the grasp and its
/// projection, the finger tips stay above the table, and `admissible` does not object.
class GraspSelector {
 public:
  /// Joint positions that put the tool centre at `T_world_tcp`; nothing if it cannot be reached.
  using Reach = std::function<std::optional<JointVector>(const Eigen::Isometry3d& T_world_tcp)>;
  /// A last word on a plan that is otherwise feasible.
  using Admissible = std::function<bool(const GraspPlan&)>;

  /// `objects` must outlive the selector. `tip_beyond_tcp`: see GripperDescription.
  GraspSelector(const std::vector<ObjectModel>& objects, const CellLayout& layout,
                double tip_beyond_tcp, Reach reach, const GraspSelectionOptions& options = {});

  /// `detections` in the world frame; those outside the pick region are ignored, strays that are
  /// looked for come after the others. Nothing is returned under condition B of Fig. 4, no-grasp.
  [[nodiscard]] std::optional<GraspPlan> select(const std::vector<Detection>& detections,
                                                const Admissible& admissible) const;

  /// The detections that lie within the pick region and belong to known objects, uppermost first,
  /// the doubtful ones after the others.
  /// Empty under condition A of Fig. 4, no-object.
  [[nodiscard]] std::vector<Detection> pickable(const std::vector<Detection>& detections) const;

  /// The strays among the detections, uppermost first; empty unless they are looked for.
  [[nodiscard]] std::vector<Detection> strays(const std::vector<Detection>& detections) const;

  /// Whether the detection is confident enough not to come last.
  [[nodiscard]] bool trusted(const Detection& detection) const noexcept {
    return detection.confidence >= options_.least_confidence;
  }

  /// All feasible grasps of one detected object, cheapest first.
  [[nodiscard]] std::vector<GraspPlan> feasible_grasps(const Detection& detection) const;

 private:
  [[nodiscard]] const ObjectModel* find_object(const std::string& name) const;
  /// The detections of known objects that `chosen` agrees with, uppermost first.
  [[nodiscard]] std::vector<Detection> by_height(
      const std::vector<Detection>& detections,
      const std::function<bool(const Detection&, double height)>& chosen) const;
  [[nodiscard]] std::optional<GraspPlan> plan(const Detection& detection, const ObjectModel& object,
                                              const Grasp& grasp) const;
  [[nodiscard]] double lowest_tip_height(const Eigen::Isometry3d& T_world_grasp,
                                         double opening) const noexcept;

  const std::vector<ObjectModel>& objects_;
  CellLayout layout_;
  double tip_beyond_tcp_;
  Reach reach_;
  GraspSelectionOptions options_;
};

}  // namespace binpick
