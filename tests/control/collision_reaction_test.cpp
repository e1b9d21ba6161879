#include "control/collision_reaction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "control/controlled_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

using State = ReactionState;

/// The tool going down at 0.1 m/s onto a floor 5 cm below, 4 cm past it.
class DescentToAFloor {
 public:
  explicit DescentToAFloor(Reaction selected, const ReactionOptions& options = {})
      : reaction(arm.controller, options),
        line_(line_from(model, pose, {0, 0, -0.09}, 0.1)),
        floor_height(model.forward_kinematics(pose).translation().z() - 0.05) {
    arm.controller.set_thresholds(
        ContactThresholds::for_phase(ContactPhase::kApproach, model.limits()));
    reaction.begin(selected);
  }

  void run(double seconds) {
    const ArmPlant::External floor = wall(Eigen::Vector3d::UnitZ(), floor_height, 2e4, 50.0);
    for (double t = 0.0; t < seconds; t += kControlPeriod) {
      if (!reaction.drives()) arm.controller.set_cartesian_target(line_.sample(path_time));
      arm.tick(floor);
      if (::testing::Test::HasFatalFailure()) return;
      reaction.update(kControlPeriod);
      path_time += reaction.path_rate() * kControlPeriod;
      lowest_rate = std::min(lowest_rate, reaction.path_rate());
      states.insert(reaction.state());
    }
  }
  [[nodiscard]] double height() const {
    return model.forward_kinematics(arm.plant.q()).translation().z() - floor_height;
  }

  ArmModel model = testing::make_arm();
  JointVector pose = test_poses()[0];
  ControlledArm arm{model, pose};
  CollisionReaction reaction;
  double path_time = 0.0;
  double lowest_rate = 1.0;
  std::set<State> states;

 private:
  CartesianTrajectory line_;

 public:
  double floor_height;
};

TEST(CollisionReaction, WithoutReactionTheMotionGoesOn) {
  DescentToAFloor descent(Reaction::kNone);
  descent.run(2.0);
  EXPECT_EQ(descent.reaction.state(), State::kContact);
  EXPECT_FALSE(descent.reaction.stopped());
  EXPECT_GT(descent.arm.controller.status().external_wrench.z(), 30.0);
}

TEST(CollisionReaction, StopHoldsWithTheSpringCancelled) {
  DescentToAFloor descent(Reaction::kStop);
  descent.run(2.0);
  EXPECT_TRUE(descent.reaction.stopped());
  EXPECT_LT(descent.arm.controller.status().external_wrench.norm(), 10.0);
  EXPECT_NEAR(descent.height(), 0.0, 0.005);
}

TEST(CollisionReaction, FloatYieldsToPushesAndThenHolds) {
  DescentToAFloor descent(Reaction::kFloat, {.float_time = 0.6});
  descent.run(1.0);
  ASSERT_EQ(descent.reaction.state(), State::kFloating);
  EXPECT_EQ(descent.arm.controller.status().mode, ControlMode::kFloating);
  const Eigen::Vector3d before = descent.arm.controller.status().T_world_tcp.translation();
  for (int i = 0; i < 200; ++i) {
    descent.arm.tick(wrench_at_tool((Vector6() << 6, 0, 0, 0, 0, 0).finished()));
  }
  EXPECT_GT((descent.arm.controller.status().T_world_tcp.translation() - before).x(), 0.01);
  descent.run(0.7);
  EXPECT_TRUE(descent.reaction.stopped());
}

TEST(CollisionReaction, RetreatLeavesTheObstacle) {
  DescentToAFloor descent(Reaction::kRetreat);
  descent.run(2.0);
  EXPECT_TRUE(descent.reaction.stopped());
  EXPECT_TRUE(descent.states.count(State::kRetreating));
  EXPECT_GT(descent.height(), 0.02);
  EXPECT_LT(descent.arm.controller.status().external_wrench.norm(), 1.0);
}

TEST(CollisionReaction, YieldGoesWithTheForceUntilItHasGone) {
  DescentToAFloor descent(Reaction::kYield);
  descent.run(2.5);
  EXPECT_TRUE(descent.reaction.stopped());
  EXPECT_TRUE(descent.states.count(State::kYielding));
  EXPECT_LT(descent.arm.controller.status().external_wrench.head<3>().norm(), 5.0);
  EXPECT_LT(std::abs(descent.height()), 0.02);
}

TEST(CollisionReaction, SlowWaitsAtAnObstacleAndGoesOnWhenItIsGone) {
  DescentToAFloor descent(Reaction::kSlow, {.slow_time = 5.0});
  descent.run(2.0);
  EXPECT_EQ(descent.reaction.state(), State::kSlowed);
  EXPECT_LT(descent.lowest_rate, 0.3);
  EXPECT_LT(descent.path_time, 1.0);
  EXPECT_LT(descent.arm.controller.status().external_wrench.z(), 20.0);
  descent.floor_height -= 1.0;
  descent.run(1.5);
  EXPECT_EQ(descent.reaction.state(), State::kNominal);
  EXPECT_NEAR(descent.height(), 1.0 - 0.04, 0.002);
}

TEST(CollisionReaction, SlowGivesUpAfterItsTime) {
  DescentToAFloor descent(Reaction::kSlow, {.slow_time = 0.5});
  descent.run(2.5);
  EXPECT_TRUE(descent.reaction.stopped());
}

TEST(CollisionReaction, EveryTransitionIsLoggedAndFollowsTheTable) {
  for (const Reaction selected : {Reaction::kNone, Reaction::kStop, Reaction::kFloat,
                                  Reaction::kRetreat, Reaction::kYield, Reaction::kSlow}) {
    DescentToAFloor descent(selected, {.slow_time = 0.5});
    descent.run(2.5);
    const std::vector<ReactionRecord> log = descent.reaction.log();
    ASSERT_EQ(log.size(), descent.reaction.transitions()) << to_text(selected);
    ASSERT_FALSE(log.empty()) << to_text(selected);
    State state = State::kNominal;
    double time = 0.0;
    for (const ReactionRecord& record : log) {
      EXPECT_EQ(record.from, state);
      EXPECT_GE(record.time, time);
      const auto& table = reaction_table();
      EXPECT_TRUE(std::any_of(table.begin(), table.end(),
                              [&](const ReactionTransition& row) {
                                return row.from == record.from && row.event == record.event &&
                                       row.to == record.to && row.action == record.action &&
                                       row.guard(selected);
                              }))
          << to_text(record.from) << " to " << to_text(record.to);
      state = record.to;
      time = record.time;
    }
    EXPECT_EQ(state, descent.reaction.state());
    EXPECT_GT(log.front().force, 4.0);
  }
}

TEST(CollisionReaction, EveryRowOfTheTableCanBeTaken) {
  // For each row some reaction reaches it first: no row is hidden by an earlier one.
  const std::vector<ReactionTransition>& table = reaction_table();
  for (std::size_t i = 0; i < table.size(); ++i) {
    bool reachable = false;
    for (const Reaction selected : {Reaction::kNone, Reaction::kStop, Reaction::kFloat,
                                    Reaction::kRetreat, Reaction::kYield, Reaction::kSlow}) {
      if (!table[i].guard(selected)) continue;
      const bool hidden = std::any_of(table.begin(), table.begin() + static_cast<long>(i),
                                      [&](const ReactionTransition& earlier) {
                                        return earlier.from == table[i].from &&
                                               earlier.event == table[i].event &&
                                               earlier.guard(selected);
                                      });
      reachable = reachable || !hidden;
    }
    EXPECT_TRUE(reachable) << "row " << i << ": " << table[i].meaning;
  }
}

TEST(CollisionReaction, RefusesOptionsWithoutMeaning) {
  ArmController controller(testing::make_arm());
  EXPECT_THROW(CollisionReaction(controller, {.float_time = 0.0}), InputError);
  EXPECT_THROW(CollisionReaction(controller, {.yield_gain = -1.0}), InputError);
}

}  // namespace
}  // namespace binpick
