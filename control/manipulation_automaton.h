#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/grasp_selection.h"
#include "control/manipulation_strategy.h"

namespace binpick {

/// The states of Fig. 4, IJRR 2012, numbered as in section 5, the end, and one more that only the
/// strategy leads to.
enum class AutomatonState {
  kGoToOverview = 1,
  kRecognizeObjects,
  kSelectGrasp,
  kGraspObject,
  kCarryAway,
  kPlaceDown,
  kHalted,
  kRearrange,
};
[[nodiscard]] std::string_view to_text(AutomatonState state) noexcept;

/// What a state's action found out: the clauses of Fig. 4 and, for the end, what the robot
/// believes.
struct AutomatonConditions {
  bool no_object = false;       ///< A
  bool no_grasp = false;        ///< B
  bool collision = false;       ///< part of C
  bool failed_grasp = false;    ///< part of C: the gripper has completely closed
  bool believed_empty = false;  ///< A, in enough looks in a row
  bool finished = false;        ///< the attempts or cycles that were asked for are used up
  // Set by the strategy alone:
  bool regrasp = false;    ///< another grasp of what was seen shall be tried at once
  bool rearrange = false;  ///< something can be pushed that can not be grasped

  [[nodiscard]] bool C() const noexcept { return collision || failed_grasp; }
};

/// One arrow of Fig. 4. Of a state's arrows the first whose guard holds is taken.
struct AutomatonTransition {
  AutomatonState from;
  bool (*guard)(const AutomatonConditions&) noexcept;
  AutomatonState to;
  std::string_view meaning;
};

/// Fig. 4 as a table, with the strategy's arrows.
[[nodiscard]] const std::vector<AutomatonTransition>& automaton_table();

/// How the attempt to grasp, carry or place went.
enum class SkillResult {
  kDone,
  kCollision,        ///< a contact beyond the threshold ended the motion of the empty gripper
  kFailedGrasp,      ///< the gripper closed completely, or on something else
  kUnreachable,      ///< no path for the arm
  kSlipped,          ///< what was held is so no longer
  kLoadedCollision,  ///< a contact beyond the threshold ended a motion with the object
};
[[nodiscard]] std::string_view to_text(SkillResult result) noexcept;

/// What the automaton's states do. The automaton decides, the skills act.
class ManipulationSkills {
 public:
  virtual ~ManipulationSkills() = default;

  /// State 1: moves the arm, from wherever it is, to a pose that does not occlude the scene.
  virtual void go_to_overview() = 0;
  /// State 2: looks; detections in the world frame.
  [[nodiscard]] virtual std::vector<Detection> recognize() = 0;
  /// State 3 asks this about every plan that fits otherwise: how much stands in the way of the open
  /// gripper, 0 for a free way.
  [[nodiscard]] virtual int obstruction(const GraspPlan& plan) = 0;
  /// How much of the space that the fingers will take up has not been seen, 0 to 1.
  [[nodiscard]] virtual double hidden_share(const GraspPlan& plan) = 0;
  /// State 3 asks this about a plan that it would take: whether the arm has a way to the grasp and
  /// from there to `slot` of `place`.
  [[nodiscard]] virtual bool has_way(const GraspPlan& plan, const Place& place,
                                     const Eigen::Vector2d& slot) = 0;
  /// State 4: approach, close, lift.
  [[nodiscard]] virtual SkillResult grasp(const GraspPlan& plan) = 0;
  /// State 5: carries what it holds above `slot` of `place`.
  [[nodiscard]] virtual SkillResult carry(const GraspPlan& plan, const Place& place,
                                          const Eigen::Vector2d& slot) = 0;
  /// State 6: lowers until contact, releases, withdraws.
  [[nodiscard]] virtual SkillResult place(const GraspPlan& plan, const Place& place,
                                          const Eigen::Vector2d& slot) = 0;

  /// The measured surface of the highest thing in the pick region, for when nothing wanted was
  /// recognized; empty if there is nothing.
  [[nodiscard]] virtual std::vector<Eigen::Vector3d> unrecognized_surface() = 0;
  /// Pushes what has this surface (points, world frame) to where it can be grasped.
  [[nodiscard]] virtual SkillResult push(const std::vector<Eigen::Vector3d>& surface) = 0;
};

struct AutomatonOptions {
  ManipulationStrategy strategy;
  /// Only objects of this model are wanted; empty for all. Others are left alone, unless the
  /// strategy clears them away.
  std::string wanted_model;
  /// The table is believed empty after this many looks in a row without an object. >= 1
  int looks_before_empty = 3;
  /// The robot gives up after this many cycles in a row without an object put away. >= 1
  int max_idle_cycles = 30;
  /// It halts after this many attempts to grasp; 0 for no limit.
  int max_attempts = 0;
  /// It halts after this many wanted objects put away; 0 for no limit.
  int max_placed = 0;
  /// A grasp that failed is avoided while the object lies within this distance of where it failed,
  /// until something has changed. m
  double same_place = 0.03;
  /// With the strategy's clearing away: an object of which so many grasps have failed waits until
  /// others, wanted or not, have been put away, if they can be.
  int max_failures = 2;
  /// Looks without an object before a push do not count as such; for so many pushes, lest something
  /// that is no known object keeps the robot busy for ever.
  int max_pushes = 5;
  /// With the strategy's search: where the pick region is empty, so many looks in a row at strays,
  /// which may be out of reach for good, do not count as empty.
  int max_stray_tries = 5;
  /// Steeper grasps only if there is no other, rad. With the strategy's steep grasps alone.
  double preferred_tilt = GraspSelectionOptions{}.max_tilt;
  /// With the strategy's hidden sides: where more of the fingers' space has not been seen, grasps
  /// are taken only if there is no other. The fingertip behind a lying object is in its shadow
  /// (about 0.15), not much more.
  double preferred_hidden_share = 0.2;
};

/// One state's execution.
struct AutomatonEvent {
  AutomatonState state;
  AutomatonConditions conditions;
  AutomatonState next;
  std::string object;  ///< the object concerned; empty if none
  std::string detail;  ///< grasp, place, counts, results
};

/// Why the automaton halted.
enum class HaltReason { kBelievedEmpty, kGaveUp, kAttemptsUsed, kPlacedEnough };

struct AutomatonResult {
  HaltReason reason = HaltReason::kBelievedEmpty;
  int placed = 0;
  std::vector<AutomatonEvent> events;
};

/// The hybrid automaton of IJRR 2012, Fig. 4: overview, recognize, select, grasp, carry, place, and
/// back to the overview after a collision or a failed grasp. With a strategy it does more, see
/// ManipulationStrategy.
class ManipulationAutomaton {
 public:
  /// Everything referred to must outlive the automaton.
  /// @throws InputError if an object has no place in `layout`.
  ManipulationAutomaton(ManipulationSkills& skills, const GraspSelector& selector,
                        const CellLayout& layout, const std::vector<ObjectModel>& objects,
                        AutomatonOptions options = {});

  /// Runs until the automaton halts by itself. Whatever the skills throw passes.
  AutomatonResult run();

  /// Called before each state's action.
  void on_state(std::function<void(AutomatonState)> callback) { on_state_ = std::move(callback); }
  /// Called after each state's action.
  void on_event(std::function<void(const AutomatonEvent&)> callback) {
    on_event_ = std::move(callback);
  }

 private:
  struct FailedGrasp {
    std::string model;
    Eigen::Isometry3d T_object_grasp;
    Eigen::Vector3d p_world_object;
  };
  struct Target {
    GraspPlan plan;
    const Place* place = nullptr;
    Eigen::Vector2d slot = Eigen::Vector2d::Zero();
  };

  AutomatonConditions act(AutomatonState state, AutomatonEvent& event);
  AutomatonConditions act_recognize(AutomatonEvent& event);
  AutomatonConditions act_select(AutomatonEvent& event);
  AutomatonConditions act_grasp(AutomatonEvent& event);
  AutomatonConditions act_carry(AutomatonEvent& event);
  AutomatonConditions act_place(AutomatonEvent& event);
  AutomatonConditions act_rearrange(AutomatonEvent& event);
  AutomatonConditions after_skill(SkillResult result, AutomatonEvent& event);

  [[nodiscard]] std::optional<GraspPlan> choose();
  /// The plan with the least in its way.
  [[nodiscard]] std::optional<GraspPlan> least_obstructed(bool also_failed);
  [[nodiscard]] bool wanted(const std::string& model) const {
    return options_.wanted_model.empty() || model == options_.wanted_model;
  }
  /// Whether the grasp that failed was one of the detected object, which has not moved since.
  [[nodiscard]] bool concerns(const FailedGrasp& failed, const Detection& detection) const;
  [[nodiscard]] bool failed_before(const GraspPlan& plan) const;
  [[nodiscard]] std::ptrdiff_t failures_with(const Detection& detection) const;
  [[nodiscard]] bool has_way(const GraspPlan& plan);
  [[nodiscard]] std::vector<Eigen::Vector3d> surface_of(const Detection& detection) const;
  [[nodiscard]] bool attempts_used() const noexcept {
    return options_.max_attempts > 0 && attempts_ >= options_.max_attempts;
  }
  [[nodiscard]] bool placed_enough() const noexcept {
    return options_.max_placed > 0 && wanted_placed_ >= options_.max_placed;
  }
  [[nodiscard]] Target target_for(GraspPlan plan) const;

  ManipulationSkills& skills_;
  const GraspSelector& selector_;
  const CellLayout& layout_;
  const std::vector<ObjectModel>& objects_;
  AutomatonOptions options_;
  std::function<void(AutomatonState)> on_state_;
  std::function<void(const AutomatonEvent&)> on_event_;

  std::vector<Detection> detections_;  ///< of wanted objects
  std::vector<Detection> others_;      ///< that may be cleared away
  std::optional<Target> target_;
  std::vector<FailedGrasp> failed_;
  /// Surfaces of what may be pushed, the most urgent first.
  std::vector<std::vector<Eigen::Vector3d>> pushable_;
  bool regrasped_ = false;  ///< since the last look
  int pushes_ = 0;
  std::vector<int> placed_per_place_;
  int placed_ = 0;
  int wanted_placed_ = 0;
  int empty_looks_ = 0;
  int stray_tries_ = 0;  ///< looks at strays since the last object was put away
  int idle_cycles_ = 0;
  int attempts_ = 0;
};

}  // namespace binpick
