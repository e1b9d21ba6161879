#include "control/grasp_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binpick {
namespace {

// The strategy's: beyond this no stored grasp keeps its finger tips off the table.
constexpr double kSteepest = 60.0 * 3.14159265358979323846 / 180.0;
// A certain miss is as bad as a tilt of 60 degrees, three times over.
constexpr double kMissWeight = 10.0;
// More likely absent than there.
constexpr double kDoubtful = 0.5;
// What lies or stands on the table by itself has its centre of mass below this, m over the table.
constexpr double kHighestStray = 0.15;

double centre_of_mass_height(const Detection& detection, const ObjectModel& object) {
  return (detection.T_scene_model * object.physics.p_model_com).z();
}

}  // namespace

double alignment_criterion(const Eigen::Isometry3d& T_world_grasp) noexcept {
  const Eigen::Vector3d v_appr = T_world_grasp.linear().col(2);
  return std::acos(std::clamp(-v_appr.z(), -1.0, 1.0));
}

double wrist_criterion(double required_wrist, double neutral_wrist) noexcept {
  return std::abs(neutral_wrist - required_wrist);
}

double miss_probability(const Detection& detection, const Grasp& grasp) {
  const Eigen::Vector3d jaw =
      detection.T_scene_model.linear() * grasp.T_object_grasp.linear().col(1);
  const Eigen::Vector3d arm = detection.T_scene_model.linear() * grasp.T_object_grasp.translation();
  // A rotation w about the model's origin moves the tool centre by w x arm.
  Eigen::Matrix<double, 6, 1> along_jaw;
  along_jaw << arm.cross(jaw), jaw;
  const double variance = along_jaw.dot(detection.covariance * along_jaw);
  if (!(variance > 0.0)) return 0.0;
  const double room = 0.5 * (grasp.pre_opening - grasp.expected_width);
  return std::erfc(std::max(room, 0.0) / std::sqrt(2.0 * variance));
}

GraspSelectionOptions GraspSelectionOptions::of(const ManipulationStrategy& strategy) noexcept {
  GraspSelectionOptions options;
  if (strategy.steep_grasps) options.max_tilt = kSteepest;
  if (strategy.uncertainty) {
    options.miss_weight = kMissWeight;
    options.least_confidence = kDoubtful;
  }
  options.strays = strategy.search;
  return options;
}

GraspSelector::GraspSelector(const std::vector<ObjectModel>& objects, const CellLayout& layout,
                             double tip_beyond_tcp, Reach reach,
                             const GraspSelectionOptions& options)
    : objects_(objects),
      layout_(layout),
      tip_beyond_tcp_(tip_beyond_tcp),
      reach_(std::move(reach)),
      options_(options) {}

const ObjectModel* GraspSelector::find_object(const std::string& name) const {
  const auto found = std::find_if(objects_.begin(), objects_.end(),
                                  [&](const ObjectModel& object) { return object.name == name; });
  return found == objects_.end() ? nullptr : &*found;
}

std::vector<Detection> GraspSelector::by_height(
    const std::vector<Detection>& detections,
    const std::function<bool(const Detection&, double height)>& chosen) const {
  std::vector<std::pair<double, Detection>> by_height;
  for (const Detection& detection : detections) {
    const ObjectModel* object = find_object(detection.model);
    if (object == nullptr) continue;
    const double height = centre_of_mass_height(detection, *object);
    if (chosen(detection, height)) by_height.emplace_back(height, detection);
  }
  std::stable_sort(by_height.begin(), by_height.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::stable_partition(by_height.begin(), by_height.end(),
                        [&](const auto& entry) { return trusted(entry.second); });
  std::vector<Detection> sorted;
  sorted.reserve(by_height.size());
  for (auto& [height, detection] : by_height) sorted.push_back(std::move(detection));
  return sorted;
}

std::vector<Detection> GraspSelector::pickable(const std::vector<Detection>& detections) const {
  return by_height(detections, [&](const Detection& detection, double) {
    const Eigen::Vector2d p_world = detection.T_scene_model.translation().head<2>();
    return layout_.pick_region.contains(p_world);
  });
}

std::vector<Detection> GraspSelector::strays(const std::vector<Detection>& detections) const {
  if (!options_.strays) return {};
  return by_height(detections, [&](const Detection& detection, double height) {
    const Eigen::Vector2d p_world = detection.T_scene_model.translation().head<2>();
    const auto near = [&](const Place& place) {
      return ((p_world - place.p_world).cwiseAbs() - 0.5 * place.size).maxCoeff() <
             options_.place_margin;
    };
    return !layout_.pick_region.contains(p_world) && trusted(detection) &&
           height < layout_.table_height + kHighestStray &&
           std::none_of(layout_.places.begin(), layout_.places.end(), near);
  });
}

std::optional<GraspPlan> GraspSelector::select(const std::vector<Detection>& detections,
                                               const Admissible& admissible) const {
  std::vector<Detection> candidates = pickable(detections);
  for (Detection& stray : strays(detections)) candidates.push_back(std::move(stray));
  for (const Detection& detection : candidates) {
    for (GraspPlan& candidate : feasible_grasps(detection)) {
      if (!admissible || admissible(candidate)) return std::move(candidate);
    }
  }
  return std::nullopt;
}

std::vector<GraspPlan> GraspSelector::feasible_grasps(const Detection& detection) const {
  std::vector<GraspPlan> plans;
  const ObjectModel* object = find_object(detection.model);
  if (object == nullptr) return plans;
  for (const Grasp& grasp : object->grasps) {
    if (auto candidate = plan(detection, *object, grasp)) plans.push_back(std::move(*candidate));
  }
  std::stable_sort(plans.begin(), plans.end(),
                   [](const GraspPlan& a, const GraspPlan& b) { return a.cost < b.cost; });
  return plans;
}

std::optional<GraspPlan> GraspSelector::plan(const Detection& detection, const ObjectModel& object,
                                             const Grasp& grasp) const {
  GraspPlan plan;
  plan.T_world_grasp = detection.T_scene_model * grasp.T_object_grasp;
  plan.tilt = alignment_criterion(plan.T_world_grasp);
  if (plan.tilt >= options_.max_tilt) return std::nullopt;
  if (lowest_tip_height(plan.T_world_grasp, grasp.pre_opening) <
      layout_.table_height + options_.tip_clearance) {
    return std::nullopt;
  }
  plan.T_world_pregrasp =
      plan.T_world_grasp * Eigen::Translation3d(0.0, 0.0, -options_.approach_distance);
  const std::optional<JointVector> q_grasp = reach_(plan.T_world_grasp);
  const std::optional<JointVector> q_pregrasp = reach_(plan.T_world_pregrasp);
  if (!q_grasp || !q_pregrasp) return std::nullopt;

  plan.detection = detection;
  plan.object = &object;
  plan.grasp = &grasp;
  plan.q_pregrasp = *q_pregrasp;
  plan.wrist = wrist_criterion((*q_grasp)[kArmJoints - 1], options_.neutral_wrist);
  plan.miss = miss_probability(detection, grasp);
  plan.cost = options_.alignment_weight * plan.tilt + options_.wrist_weight * plan.wrist +
              options_.miss_weight * plan.miss;
  return plan;
}

double GraspSelector::lowest_tip_height(const Eigen::Isometry3d& T_world_grasp,
                                        double opening) const noexcept {
  double lowest = std::numeric_limits<double>::infinity();
  for (const double side : {-0.5, 0.5}) {
    const Eigen::Vector3d tip =
        T_world_grasp * Eigen::Vector3d(0.0, side * opening, tip_beyond_tcp_);
    lowest = std::min(lowest, tip.z());
  }
  return lowest;
}

}  // namespace binpick
