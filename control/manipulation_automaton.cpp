#include "control/manipulation_automaton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "models/errors.h"
#include "models/mesh_geometry.h"

namespace binpick {
namespace {

// Of something to be pushed: one per square centimetre or denser.
constexpr std::size_t kSurfacePoints = 1000;

using enum AutomatonState;
using Conditions = AutomatonConditions;

bool always(const Conditions&) noexcept { return true; }
bool no_object(const Conditions& c) noexcept { return c.no_object; }
bool no_grasp(const Conditions& c) noexcept { return c.no_grasp; }
bool collision_or_failed_grasp(const Conditions& c) noexcept { return c.C(); }
bool believed_empty(const Conditions& c) noexcept { return c.believed_empty; }
bool finished(const Conditions& c) noexcept { return c.finished; }
bool regrasp(const Conditions& c) noexcept { return c.regrasp; }
bool rearrange(const Conditions& c) noexcept { return c.rearrange; }

const Place* find_place(const CellLayout& layout, const std::string& model) {
  for (const Place& place : layout.places) {
    if (std::find(place.objects.begin(), place.objects.end(), model) != place.objects.end()) {
      return &place;
    }
  }
  return nullptr;
}

/// Whether the tool comes to the same place in the same direction; the jaws may have changed sides.
bool same_grasp(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kSamePoint = 0.005;     // m
  constexpr double kSameDirection = 0.99;  // cosine of 8 degrees
  return (a.translation() - b.translation()).norm() < kSamePoint &&
         a.linear().col(2).dot(b.linear().col(2)) > kSameDirection &&
         std::abs(a.linear().col(1).dot(b.linear().col(1))) > kSameDirection;
}

}  // namespace

const std::vector<AutomatonTransition>& automaton_table() {
  static const std::vector<AutomatonTransition> kFigure4 = {
      {kGoToOverview, always, kRecognizeObjects, "the scene is in full view"},
      {kRecognizeObjects, believed_empty, kHalted, "A, often enough: the table is empty"},
      {kRecognizeObjects, finished, kHalted, "no progress for too long"},
      {kRecognizeObjects, rearrange, kRearrange, "strategy: something unknown lies there"},
      {kRecognizeObjects, no_object, kGoToOverview, "A: look again"},
      {kRecognizeObjects, always, kSelectGrasp, "not A"},
      {kSelectGrasp, finished, kHalted, "no progress for too long"},
      {kSelectGrasp, rearrange, kRearrange, "strategy: B, but it can be pushed"},
      {kSelectGrasp, no_grasp, kGoToOverview, "B: look again"},
      {kSelectGrasp, always, kGraspObject, "not B"},
      {kGraspObject, finished, kHalted, "the attempts are used up"},
      {kGraspObject, regrasp, kSelectGrasp, "strategy: closed empty, another grasp"},
      {kGraspObject, collision_or_failed_grasp, kGoToOverview, "C"},
      {kGraspObject, always, kCarryAway, "not C"},
      {kCarryAway, finished, kHalted, "the attempts are used up"},
      {kCarryAway, collision_or_failed_grasp, kGoToOverview, "C: lost on the way"},
      {kCarryAway, always, kPlaceDown, "not C"},
      {kPlaceDown, finished, kHalted, "the attempts are used up"},
      {kPlaceDown, always, kGoToOverview, "next object"},
      {kRearrange, always, kGoToOverview, "strategy: see what it led to"},
  };
  return kFigure4;
}

std::string_view to_text(AutomatonState state) noexcept {
  switch (state) {
    case kGoToOverview:
      return "go to overview";
    case kRecognizeObjects:
      return "recognize objects";
    case kSelectGrasp:
      return "select a grasp";
    case kGraspObject:
      return "grasp object";
    case kCarryAway:
      return "carry away";
    case kPlaceDown:
      return "place down";
    case kHalted:
      return "halted";
    case kRearrange:
      return "rearrange";
  }
  return "";
}

std::string_view to_text(SkillResult result) noexcept {
  switch (result) {
    case SkillResult::kDone:
      return "done";
    case SkillResult::kCollision:
      return "collision";
    case SkillResult::kFailedGrasp:
      return "failed grasp";
    case SkillResult::kUnreachable:
      return "unreachable";
    case SkillResult::kSlipped:
      return "slipped";
    case SkillResult::kLoadedCollision:
      return "collision with the object held";
  }
  return "";
}

ManipulationAutomaton::ManipulationAutomaton(ManipulationSkills& skills,
                                             const GraspSelector& selector,
                                             const CellLayout& layout,
                                             const std::vector<ObjectModel>& objects,
                                             AutomatonOptions options)
    : skills_(skills),
      selector_(selector),
      layout_(layout),
      objects_(objects),
      options_(std::move(options)),
      placed_per_place_(layout.places.size(), 0) {
  for (const ObjectModel& object : objects) {
    const Place* place = find_place(layout, object.name);
    if (place == nullptr || place->slots.empty()) {
      throw InputError(fmt::format(
          "the cell has no place for '{}': add it to the objects of a place with a slot",
          object.name));
    }
  }
}

AutomatonResult ManipulationAutomaton::run() {
  AutomatonResult result;
  AutomatonState state = kGoToOverview;
  while (state != kHalted) {
    if (on_state_) on_state_(state);
    AutomatonEvent event{state, {}, kHalted, {}, {}};
    event.conditions = act(state, event);
    for (const AutomatonTransition& arrow : automaton_table()) {
      if (arrow.from == state && arrow.guard(event.conditions)) {
        event.next = arrow.to;
        break;
      }
    }
    state = event.next;
    if (on_event_) on_event_(event);
    result.events.push_back(std::move(event));
  }
  const Conditions& last = result.events.back().conditions;
  result.reason = last.believed_empty ? HaltReason::kBelievedEmpty
                  : placed_enough()   ? HaltReason::kPlacedEnough
                  : attempts_used()   ? HaltReason::kAttemptsUsed
                                      : HaltReason::kGaveUp;
  result.placed = placed_;
  return result;
}

AutomatonConditions ManipulationAutomaton::act(AutomatonState state, AutomatonEvent& event) {
  switch (state) {
    case kGoToOverview:
      skills_.go_to_overview();
      return {};
    case kRecognizeObjects:
      return act_recognize(event);
    case kSelectGrasp:
      return act_select(event);
    case kGraspObject:
      return act_grasp(event);
    case kCarryAway:
      return act_carry(event);
    case kPlaceDown:
      return act_place(event);
    case kRearrange:
      return act_rearrange(event);
    case kHalted:
      break;
  }
  return {};
}

AutomatonConditions ManipulationAutomaton::act_recognize(AutomatonEvent& event) {
  const std::vector<Detection> seen = skills_.recognize();
  detections_.clear();
  others_.clear();
  for (Detection& detection : selector_.pickable(seen)) {
    (wanted(detection.model) ? detections_ : others_).push_back(std::move(detection));
  }
  if (detections_.empty() && stray_tries_ < options_.max_stray_tries) {
    for (Detection& detection : selector_.strays(seen)) {
      if (wanted(detection.model)) detections_.push_back(std::move(detection));
    }
    if (!detections_.empty()) ++stray_tries_;
  }
  event.detail = fmt::format("{} objects to pick, {} seen", detections_.size(), seen.size());
  regrasped_ = false;

  AutomatonConditions conditions;
  // What is wanted may lie below others, which are put away first.
  conditions.no_object = detections_.empty() && (!options_.strategy.clear_away || others_.empty());
  if (conditions.no_object && options_.strategy.search) {
    pushable_ = {skills_.unrecognized_surface()};
    conditions.rearrange = !pushable_.front().empty();
  }
  empty_looks_ = conditions.no_object ? empty_looks_ + 1 : 0;
  conditions.believed_empty = empty_looks_ >= options_.looks_before_empty;
  conditions.finished = ++idle_cycles_ > options_.max_idle_cycles;
  return conditions;
}

AutomatonConditions ManipulationAutomaton::act_select(AutomatonEvent& event) {
  std::optional<GraspPlan> plan = choose();
  AutomatonConditions conditions;
  conditions.no_grasp = !plan;
  if (plan) {
    event.object = plan->detection.model;
    event.detail = fmt::format("{}, cost {:.3f}", plan->grasp->name, plan->cost);
    target_ = target_for(std::move(*plan));
  } else if (options_.strategy.search) {
    pushable_.clear();
    for (const std::vector<Detection>* found : {&detections_, &others_}) {
      for (const Detection& detection : *found) pushable_.push_back(surface_of(detection));
    }
    conditions.rearrange = !pushable_.empty();
  }
  return conditions;
}

std::optional<GraspPlan> ManipulationAutomaton::choose() {
  const auto free = [&](const GraspPlan& plan) {
    return !failed_before(plan) && skills_.obstruction(plan) == 0 && has_way(plan);
  };
  const auto good = [&](const GraspPlan& plan) {
    const bool seen = !options_.strategy.hidden_sides ||
                      skills_.hidden_share(plan) <= options_.preferred_hidden_share;
    return plan.tilt < options_.preferred_tilt && selector_.trusted(plan.detection) && seen &&
           free(plan);
  };
  const auto new_and = [&](auto condition) {
    return [this, condition](const GraspPlan& plan) {
      return failures_with(plan.detection) < options_.max_failures && condition(plan);
    };
  };
  if (options_.strategy.clear_away) {
    for (const auto* found : {&detections_, &others_}) {
      if (auto plan = selector_.select(*found, new_and(good))) return plan;
      if (auto plan = selector_.select(*found, new_and(free))) return plan;
    }
  }
  if (auto plan = selector_.select(detections_, good)) return plan;
  if (auto plan = selector_.select(detections_, free)) return plan;
  // Nothing is free: the way with the least in it, if need be one that failed before.
  if (auto plan = least_obstructed(false)) return plan;
  failed_.clear();
  return least_obstructed(true);
}

std::optional<GraspPlan> ManipulationAutomaton::least_obstructed(bool also_failed) {
  // With the strategy, what grasps failed at comes after the other objects here, too.
  using Rank = std::pair<bool, int>;
  std::vector<std::pair<Rank, GraspPlan>> plans;
  for (const Detection& detection : detections_) {
    const bool waits =
        options_.strategy.clear_away && failures_with(detection) >= options_.max_failures;
    for (GraspPlan& plan : selector_.feasible_grasps(detection)) {
      if (!also_failed && failed_before(plan)) continue;
      plans.emplace_back(Rank(waits, skills_.obstruction(plan)), std::move(plan));
    }
  }
  std::stable_sort(plans.begin(), plans.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [rank, plan] : plans) {
    if (has_way(plan)) return std::move(plan);
  }
  return std::nullopt;
}

bool ManipulationAutomaton::has_way(const GraspPlan& plan) {
  const Target target = target_for(plan);
  return skills_.has_way(target.plan, *target.place, target.slot);
}

std::vector<Eigen::Vector3d> ManipulationAutomaton::surface_of(const Detection& detection) const {
  std::vector<Eigen::Vector3d> surface;
  for (const ObjectModel& object : objects_) {
    if (object.name != detection.model) continue;
    const PointCloud points = sample_surface(object.mesh, kSurfacePoints, 0);
    for (const Eigen::Vector3f& p_model : points.points) {
      surface.push_back(detection.T_scene_model * p_model.cast<double>());
    }
  }
  return surface;
}

AutomatonConditions ManipulationAutomaton::act_grasp(AutomatonEvent& event) {
  ++attempts_;
  const SkillResult result = skills_.grasp(target_->plan);
  AutomatonConditions conditions = after_skill(result, event);
  conditions.regrasp =
      options_.strategy.regrasp && result == SkillResult::kFailedGrasp && !regrasped_;
  regrasped_ = regrasped_ || conditions.regrasp;
  return conditions;
}

AutomatonConditions ManipulationAutomaton::act_carry(AutomatonEvent& event) {
  return after_skill(skills_.carry(target_->plan, *target_->place, target_->slot), event);
}

AutomatonConditions ManipulationAutomaton::act_place(AutomatonEvent& event) {
  const SkillResult result = skills_.place(target_->plan, *target_->place, target_->slot);
  AutomatonConditions conditions = after_skill(result, event);
  if (result == SkillResult::kDone) {
    ++placed_;
    if (wanted(target_->plan.detection.model)) ++wanted_placed_;
    ++placed_per_place_[static_cast<std::size_t>(target_->place - layout_.places.data())];
    failed_.clear();
    idle_cycles_ = 0;
    stray_tries_ = 0;
  }
  conditions.finished = attempts_used() || placed_enough();
  return conditions;
}

AutomatonConditions ManipulationAutomaton::act_rearrange(AutomatonEvent& event) {
  for (const std::vector<Eigen::Vector3d>& surface : pushable_) {
    const SkillResult result = skills_.push(surface);
    event.detail = fmt::format("push: {}", to_text(result));
    if (result == SkillResult::kUnreachable) continue;
    failed_.clear();
    if (++pushes_ <= options_.max_pushes) empty_looks_ = 0;
    break;
  }
  return {};
}

AutomatonConditions ManipulationAutomaton::after_skill(SkillResult result, AutomatonEvent& event) {
  const GraspPlan& plan = target_->plan;
  event.object = plan.detection.model;
  event.detail = fmt::format("{}: {}", plan.grasp->name, to_text(result));
  AutomatonConditions conditions;
  // No path for the arm ends an attempt just as a collision does: overview, and look again.
  conditions.collision = result == SkillResult::kCollision ||
                         result == SkillResult::kLoadedCollision ||
                         result == SkillResult::kUnreachable;
  conditions.failed_grasp = result == SkillResult::kFailedGrasp || result == SkillResult::kSlipped;
  if (conditions.C()) {
    failed_.push_back({plan.detection.model, plan.grasp->T_object_grasp,
                       plan.detection.T_scene_model.translation()});
    conditions.finished = attempts_used();
  }
  return conditions;
}

bool ManipulationAutomaton::concerns(const FailedGrasp& failed, const Detection& detection) const {
  const Eigen::Vector3d moved = detection.T_scene_model.translation() - failed.p_world_object;
  return failed.model == detection.model && moved.norm() < options_.same_place;
}

bool ManipulationAutomaton::failed_before(const GraspPlan& plan) const {
  return std::any_of(failed_.begin(), failed_.end(), [&](const FailedGrasp& failed) {
    return concerns(failed, plan.detection) &&
           same_grasp(failed.T_object_grasp, plan.grasp->T_object_grasp);
  });
}

std::ptrdiff_t ManipulationAutomaton::failures_with(const Detection& detection) const {
  return std::count_if(failed_.begin(), failed_.end(),
                       [&](const FailedGrasp& failed) { return concerns(failed, detection); });
}

ManipulationAutomaton::Target ManipulationAutomaton::target_for(GraspPlan plan) const {
  Target target;
  target.place = find_place(layout_, plan.detection.model);
  const auto index = static_cast<std::size_t>(target.place - layout_.places.data());
  const auto used = static_cast<std::size_t>(placed_per_place_[index]);
  target.slot = target.place->slots[used % target.place->slots.size()];
  target.plan = std::move(plan);
  return target;
}

}  // namespace binpick
