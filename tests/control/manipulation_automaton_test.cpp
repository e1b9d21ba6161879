#include "control/manipulation_automaton.h"

#include <gmock/gmock.h>

#include <deque>
#include <numbers>
#include <set>

#include "models/errors.h"

namespace binpick {
namespace {

using enum AutomatonState;

ObjectModel cube() {
  ObjectModel object;
  object.name = "cube";
  object.symmetries = {Eigen::Isometry3d::Identity()};
  for (const char* name : {"first", "second"}) {
    Grasp grasp;
    grasp.name = name;
    // Approach straight down; the second costs more wrist.
    grasp.T_object_grasp.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    grasp.T_object_grasp.translation().z() = object.grasps.empty() ? 0.02 : 0.03;
    grasp.pre_opening = 0.08;
    object.grasps.push_back(grasp);
  }
  return object;
}

CellLayout layout() {
  CellLayout layout;
  layout.pick_region = Eigen::AlignedBox2d(Eigen::Vector2d(0.3, -0.3), Eigen::Vector2d(0.8, 0.3));
  Place place;
  place.name = "corner";
  place.objects = {"cube"};
  place.slots = {Eigen::Vector2d(0.0, 0.5), Eigen::Vector2d(0.1, 0.5)};
  layout.places.push_back(place);
  return layout;
}

Detection cube_at(double x, double z) {
  Detection detection;
  detection.model = "cube";
  detection.T_scene_model.translation() << x, 0.0, z;
  return detection;
}

/// Plays a script instead of acting, and keeps what it was asked to do.
class ScriptedSkills : public ManipulationSkills {
 public:
  std::deque<std::vector<Detection>> views;
  std::deque<SkillResult> grasps;
  std::deque<SkillResult> carries;
  std::deque<SkillResult> pushes;
  std::deque<std::vector<Eigen::Vector3d>> surfaces;
  std::set<std::string> obstructed;
  std::set<std::string> unreachable;
  std::set<std::string> in_shadow;
  std::vector<std::string> log;
  std::function<void(const GraspPlan&)> on_grasp;

  void go_to_overview() override { log.push_back("overview"); }
  std::vector<Detection> recognize() override {
    log.push_back("recognize");
    return take(views, {});
  }
  int obstruction(const GraspPlan& plan) override {
    return obstructed.contains(plan.grasp->name) ? 50 : 0;
  }
  double hidden_share(const GraspPlan& plan) override {
    return in_shadow.contains(plan.grasp->name) ? 0.9 : 0.0;
  }
  bool has_way(const GraspPlan& plan, const Place&, const Eigen::Vector2d&) override {
    return !unreachable.contains(plan.grasp->name);
  }
  std::vector<Eigen::Vector3d> unrecognized_surface() override { return take(surfaces, {}); }
  SkillResult push(const std::vector<Eigen::Vector3d>&) override {
    log.push_back("push");
    return take(pushes, SkillResult::kDone);
  }
  SkillResult grasp(const GraspPlan& plan) override {
    log.push_back("grasp " + plan.grasp->name);
    if (on_grasp) on_grasp(plan);
    return take(grasps, SkillResult::kDone);
  }
  SkillResult carry(const GraspPlan&, const Place&, const Eigen::Vector2d& slot) override {
    log.push_back("carry");
    slots.push_back(slot);
    return take(carries, SkillResult::kDone);
  }
  SkillResult place(const GraspPlan&, const Place&, const Eigen::Vector2d&) override {
    log.push_back("place");
    return SkillResult::kDone;
  }
  std::vector<Eigen::Vector2d> slots;

 private:
  template <class T>
  static T take(std::deque<T>& script, T otherwise) {
    if (script.empty()) return otherwise;
    T value = script.front();
    script.pop_front();
    return value;
  }
};

class ManipulationAutomatonTest : public ::testing::Test {
 protected:
  AutomatonResult run(AutomatonOptions options = {}) {
    ManipulationAutomaton automaton(skills_, selector_, layout_, objects_, options);
    return automaton.run();
  }

  /// Makes a second kind known that is like the cube, and sees one on top of it.
  Detection add_lid() {
    objects_.push_back(objects_[0]);
    objects_[1].name = "lid";
    for (Grasp& grasp : objects_[1].grasps) grasp.name += " of the lid";
    layout_.places[0].objects.push_back("lid");
    Detection lid = cube_at(0.5, 0.2);
    lid.model = "lid";
    return lid;
  }

  std::vector<ObjectModel> objects_{cube()};
  CellLayout layout_ = layout();
  // Every pose can be reached; the first grasp needs no wrist, the second does.
  int asked_ = 0;
  GraspSelector selector_{objects_, layout_, 0.015,
                          [this](const Eigen::Isometry3d&) -> std::optional<JointVector> {
                            JointVector q = JointVector::Zero();
                            q[6] = (asked_++ / 2) % 2 == 0 ? 0.0 : 1.0;
                            return q;
                          }};
  ScriptedSkills skills_;
};

TEST_F(ManipulationAutomatonTest, RunsThroughFigure4AndHaltsWhenItBelievesTheTableEmpty) {
  skills_.views = {{cube_at(0.5, 0.1)}};
  const AutomatonResult result = run();
  EXPECT_EQ(result.reason, HaltReason::kBelievedEmpty);
  EXPECT_EQ(result.placed, 1);
  EXPECT_THAT(skills_.log, ::testing::ElementsAre("overview", "recognize", "grasp first", "carry",
                                                  "place", "overview", "recognize", "overview",
                                                  "recognize", "overview", "recognize"));
}

TEST_F(ManipulationAutomatonTest, GoesBackToTheOverviewAfterACollision) {
  skills_.views = {{cube_at(0.5, 0.1)}, {cube_at(0.5, 0.1)}};
  skills_.grasps = {SkillResult::kCollision};
  const AutomatonResult result = run();
  EXPECT_EQ(result.placed, 1);
  const auto& after_collision = result.events[3];
  EXPECT_EQ(after_collision.state, kGraspObject);
  EXPECT_TRUE(after_collision.conditions.C());
  EXPECT_EQ(after_collision.next, kGoToOverview);
}

TEST_F(ManipulationAutomatonTest, DoesNotRepeatAFailedGraspWhileAnotherOneIsLeft) {
  const std::vector<Detection> view{cube_at(0.5, 0.1)};
  skills_.views = {view, view, view};
  skills_.grasps = {SkillResult::kFailedGrasp, SkillResult::kFailedGrasp};
  const AutomatonResult result = run();
  EXPECT_EQ(result.placed, 1);
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp second").Times(1));
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp first").Times(2));
}

TEST_F(ManipulationAutomatonTest, PrefersAGraspWithAFreeWayToACheaperOne) {
  skills_.views = {{cube_at(0.5, 0.1)}};
  skills_.obstructed = {"first"};
  run();
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp second"));
}

TEST_F(ManipulationAutomatonTest, IgnoresDetectionsOutsideThePickRegion) {
  skills_.views = {{cube_at(0.1, 0.1)}, {cube_at(0.1, 0.1)}, {cube_at(0.1, 0.1)}};
  const AutomatonResult result = run();
  EXPECT_EQ(result.reason, HaltReason::kBelievedEmpty);
  EXPECT_EQ(result.placed, 0);
}

TEST_F(ManipulationAutomatonTest, GivesUpAfterThirtyCyclesWithoutProgress) {
  for (int i = 0; i < 100; ++i) skills_.views.push_back({cube_at(0.5, 0.1)});
  for (int i = 0; i < 100; ++i) skills_.grasps.push_back(SkillResult::kCollision);
  const AutomatonResult result = run();
  EXPECT_EQ(result.reason, HaltReason::kGaveUp);
  EXPECT_EQ(result.events.back().state, AutomatonState::kRecognizeObjects);
  EXPECT_FALSE(result.events.back().conditions.no_object) << "it was seen to the end";
  EXPECT_THAT(skills_.log, ::testing::Contains("recognize").Times(31));
}

TEST_F(ManipulationAutomatonTest, UsesThePlacesSlotsInOrderAndNotForWhatWasLost) {
  const std::vector<Detection> view{cube_at(0.5, 0.1)};
  skills_.views = {view, view, view};
  skills_.carries = {SkillResult::kDone, SkillResult::kFailedGrasp, SkillResult::kDone};
  run();
  ASSERT_EQ(skills_.slots.size(), 3u);
  EXPECT_EQ(skills_.slots[0], layout_.places[0].slots[0]);
  EXPECT_EQ(skills_.slots[1], layout_.places[0].slots[1]);
  EXPECT_EQ(skills_.slots[2], layout_.places[0].slots[1]);
}

TEST_F(ManipulationAutomatonTest, HaltsAfterTheAttemptsItWasGiven) {
  skills_.views = {{cube_at(0.5, 0.1)}, {cube_at(0.5, 0.1)}};
  skills_.grasps = {SkillResult::kCollision};
  AutomatonOptions options;
  options.max_attempts = 1;
  const AutomatonResult result = run(options);
  EXPECT_EQ(result.reason, HaltReason::kAttemptsUsed);
  EXPECT_EQ(result.events.back().state, kGraspObject);
}

TEST_F(ManipulationAutomatonTest, HaltsWhenItHasPutAwayAsManyAsItWasTold) {
  skills_.views = {{cube_at(0.5, 0.1)}, {cube_at(0.5, 0.1)}, {cube_at(0.5, 0.1)}};
  skills_.grasps = {SkillResult::kCollision, SkillResult::kDone};
  AutomatonOptions options;
  options.max_attempts = 5;
  options.max_placed = 1;
  const AutomatonResult result = run(options);
  EXPECT_EQ(result.reason, HaltReason::kPlacedEnough);
  EXPECT_EQ(result.placed, 1);
}

TEST_F(ManipulationAutomatonTest, TakesNoGraspThatLeavesNoWayToThePlace) {
  skills_.views = {{cube_at(0.5, 0.1)}};
  skills_.unreachable = {"first"};
  run();
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp second"));
  EXPECT_THAT(skills_.log, ::testing::Not(::testing::Contains("grasp first")));
}

TEST_F(ManipulationAutomatonTest, AGraspWithTheJawsTheOtherWayRoundIsTheSameGrasp) {
  objects_[0].grasps[1].T_object_grasp = objects_[0].grasps[0].T_object_grasp;
  objects_[0].grasps[1].T_object_grasp.rotate(
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  Grasp third = objects_[0].grasps[0];
  third.name = "third";
  third.T_object_grasp.translation().z() = 0.04;
  objects_[0].grasps.push_back(third);
  const std::vector<Detection> view{cube_at(0.5, 0.1)};
  skills_.views = {view, view};
  skills_.grasps = {SkillResult::kCollision};
  run();
  EXPECT_THAT(skills_.log, ::testing::Not(::testing::Contains("grasp second")));
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp third"));
}

TEST_F(ManipulationAutomatonTest, TheStrategyTriesAnotherGraspAtOnceButOncePerLook) {
  const std::vector<Detection> view{cube_at(0.5, 0.1)};
  skills_.views = {view, view};
  skills_.grasps = {SkillResult::kFailedGrasp, SkillResult::kFailedGrasp};
  AutomatonOptions options;
  options.strategy.regrasp = true;
  run(options);
  ASSERT_GE(skills_.log.size(), 6u);
  EXPECT_EQ(skills_.log[2], "grasp first");
  EXPECT_EQ(skills_.log[3], "grasp second");
  EXPECT_EQ(skills_.log[4], "overview");
  EXPECT_EQ(skills_.log[5], "recognize");
}

TEST_F(ManipulationAutomatonTest, ACollisionIsNoReasonToRegraspWithoutALook) {
  const std::vector<Detection> view{cube_at(0.5, 0.1)};
  skills_.views = {view, view};
  skills_.grasps = {SkillResult::kCollision};
  AutomatonOptions options;
  options.strategy.regrasp = true;
  run(options);
  EXPECT_EQ(skills_.log[3], "overview");
}

TEST_F(ManipulationAutomatonTest, TheStrategyPushesWhatItCannotGrasp) {
  const std::vector<Detection> view{cube_at(0.5, 0.1)};
  skills_.views = {view, view};
  skills_.unreachable = {"first", "second"};
  AutomatonOptions options;
  run(options);
  EXPECT_THAT(skills_.log, ::testing::Not(::testing::Contains("push")));

  skills_.log.clear();
  skills_.views = {view, view};
  options.strategy.search = true;
  run(options);
  EXPECT_THAT(skills_.log, ::testing::Contains("push").Times(2));
}

TEST_F(ManipulationAutomatonTest, TheStrategyPushesWhatItSeesAndDoesNotRecognizeButNotForEver) {
  skills_.surfaces.assign(100, {Eigen::Vector3d(0.4, 0.0, 0.05)});
  AutomatonOptions options;
  options.strategy.search = true;
  options.max_pushes = 4;
  const AutomatonResult result = run(options);
  EXPECT_EQ(result.reason, HaltReason::kBelievedEmpty);
  // After the fourth push, looks count: two more are pushed at before the third is believed.
  EXPECT_THAT(skills_.log, ::testing::Contains("push").Times(6));
}

TEST_F(ManipulationAutomatonTest, WhatCannotBePushedDelaysNothing) {
  skills_.surfaces.assign(100, {Eigen::Vector3d(0.4, 0.0, 0.05)});
  skills_.pushes.assign(100, SkillResult::kUnreachable);
  AutomatonOptions options;
  options.strategy.search = true;
  run(options);
  EXPECT_THAT(skills_.log, ::testing::Contains("recognize").Times(3));
}

TEST_F(ManipulationAutomatonTest, TheStrategyPrefersFingersWhereItHasSeenThatThereIsRoom) {
  skills_.in_shadow = {"first"};
  skills_.views = {{cube_at(0.5, 0.1)}};
  run();
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp first"));

  skills_.log.clear();
  skills_.views = {{cube_at(0.5, 0.1)}};
  AutomatonOptions options;
  options.strategy.hidden_sides = true;
  run(options);
  EXPECT_THAT(skills_.log, ::testing::Contains("grasp second"));
}

TEST_F(ManipulationAutomatonTest, TheStrategyClearsAwayWhatStandsInTheWayOfTheWanted) {
  const Detection lid = add_lid();
  AutomatonOptions options;
  options.wanted_model = "cube";
  options.max_placed = 1;
  skills_.obstructed = {"first", "second"};
  skills_.views = {{lid, cube_at(0.5, 0.1)}, {cube_at(0.5, 0.1)}};
  run(options);
  EXPECT_THAT(skills_.log, ::testing::Not(::testing::Contains("grasp first of the lid")));

  skills_.log.clear();
  skills_.views = {{lid, cube_at(0.5, 0.1)}, {cube_at(0.5, 0.1)}};
  options.strategy.clear_away = true;
  const AutomatonResult result = run(options);
  EXPECT_EQ(result.placed, 2);
  EXPECT_EQ(result.reason, HaltReason::kPlacedEnough);
  EXPECT_EQ(skills_.log[2], "grasp first of the lid");
}

TEST_F(ManipulationAutomatonTest, TheStrategyPutsAwayWhatMayLieOverTheWanted) {
  const Detection lid = add_lid();
  AutomatonOptions options;
  options.wanted_model = "cube";
  options.max_placed = 1;
  options.strategy.search = true;
  options.strategy.clear_away = true;
  skills_.surfaces.assign(100, {Eigen::Vector3d(0.5, 0.0, 0.2)});
  skills_.views = {{lid}, {cube_at(0.5, 0.1)}};
  const AutomatonResult result = run(options);
  EXPECT_EQ(result.placed, 2);
  EXPECT_EQ(skills_.log[2], "grasp first of the lid");
  EXPECT_THAT(skills_.log, ::testing::Not(::testing::Contains("push")));
}

TEST_F(ManipulationAutomatonTest, TheStrategyLeavesWhatItFailedAtTwiceForLater) {
  for (const char* name : {"third", "fourth"}) {
    Grasp grasp = objects_[0].grasps[0];
    grasp.name = name;
    grasp.T_object_grasp.translation().z() += 0.02 * static_cast<double>(objects_[0].grasps.size());
    objects_[0].grasps.push_back(grasp);
  }
  const std::vector<Detection> view{cube_at(0.5, 0.2), cube_at(0.7, 0.1)};
  AutomatonOptions options;
  options.max_placed = 1;
  for (const bool clear_away : {false, true}) {
    skills_.views.assign(10, view);
    skills_.grasps.assign(2, SkillResult::kCollision);
    skills_.slots.clear();
    options.strategy.clear_away = clear_away;
    std::vector<double> grasped_at;
    ManipulationAutomaton automaton(skills_, selector_, layout_, objects_, options);
    skills_.on_grasp = [&](const GraspPlan& plan) {
      grasped_at.push_back(plan.detection.T_scene_model.translation().x());
    };
    EXPECT_EQ(automaton.run().placed, 1);
    EXPECT_THAT(grasped_at, ::testing::ElementsAre(0.5, 0.5, clear_away ? 0.7 : 0.5));
  }

  // So it does where everything is in the way of everything.
  skills_.on_grasp = nullptr;
  skills_.obstructed = {"first", "second", "third", "fourth"};
  skills_.views.assign(10, view);
  skills_.grasps.assign(2, SkillResult::kCollision);
  skills_.log.clear();
  const AutomatonResult result = run(options);
  EXPECT_THAT(skills_.log, ::testing::Contains(::testing::StartsWith("grasp")).Times(3));
  EXPECT_EQ(result.placed, 1);
}

TEST_F(ManipulationAutomatonTest, TheStrategyFetchesStraysOnceThePickRegionIsEmpty) {
  GraspSelectionOptions selection;
  selection.strays = true;
  const GraspSelector selector(
      objects_, layout_, 0.015, [](const Eigen::Isometry3d&) { return JointVector::Zero(); },
      selection);
  const Detection stray = cube_at(0.2, 0.05);
  const Detection inside = cube_at(0.5, 0.05);
  skills_.views = {{stray, inside}, {stray}};
  const AutomatonResult result = ManipulationAutomaton(skills_, selector, layout_, objects_).run();
  EXPECT_EQ(result.placed, 2);
  EXPECT_EQ(result.events[2].detail.find("second"), std::string::npos);

  // Those that stay out of reach do not keep the robot from its belief.
  skills_.views.assign(100, {stray});
  skills_.unreachable = {"first", "second"};
  const AutomatonResult vain = ManipulationAutomaton(skills_, selector, layout_, objects_).run();
  EXPECT_EQ(vain.reason, HaltReason::kBelievedEmpty);
}

TEST_F(ManipulationAutomatonTest, RefusesObjectsThatHaveNoPlace) {
  layout_.places.clear();
  EXPECT_THROW(ManipulationAutomaton(skills_, selector_, layout_, objects_), InputError);
}

TEST(AutomatonTable, EveryStateHasAnArrowThatIsAlwaysOpen) {
  for (const AutomatonState state :
       {kGoToOverview, kRecognizeObjects, kSelectGrasp, kGraspObject, kCarryAway, kPlaceDown}) {
    bool open = false;
    for (const AutomatonTransition& arrow : automaton_table()) {
      open = open || (arrow.from == state && arrow.guard({}));
    }
    EXPECT_TRUE(open) << to_text(state);
  }
}

}  // namespace
}  // namespace binpick
