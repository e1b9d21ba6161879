#include "control/grasp_selection.h"

#include <gtest/gtest.h>

#include <numbers>

namespace binpick {
namespace {

/// A tool pose that approaches at `tilt` from straight down.
Eigen::Isometry3d approach(double tilt) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::AngleAxisd(std::numbers::pi - tilt, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T;
}

Grasp tilted_grasp(const std::string& name, double tilt) {
  Grasp grasp;
  grasp.name = name;
  grasp.T_object_grasp = approach(tilt);
  grasp.T_object_grasp.translation().z() = 0.03;
  grasp.pre_opening = 0.05;
  return grasp;
}

ObjectModel object_with(const std::string& name, std::vector<Grasp> grasps) {
  ObjectModel object;
  object.name = name;
  object.grasps = std::move(grasps);
  object.symmetries = {Eigen::Isometry3d::Identity()};
  return object;
}

Detection at(const std::string& model, double x, double z) {
  Detection detection;
  detection.model = model;
  detection.T_scene_model.translation() << x, 0.0, z;
  return detection;
}

std::optional<JointVector> anywhere(const Eigen::Isometry3d&) { return JointVector::Zero(); }

CellLayout wide_layout() {
  CellLayout layout;
  layout.pick_region = Eigen::AlignedBox2d(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1));
  return layout;
}

constexpr double kDeg = std::numbers::pi / 180.0;

TEST(GraspSelection, AlignmentCriterionIsTheAngleBetweenBackwardApproachAndUp) {
  for (const double tilt : {0.0, 10.0, 29.0, 90.0, 150.0}) {
    EXPECT_NEAR(alignment_criterion(approach(tilt * kDeg)), tilt * kDeg, 1e-7);
  }
}

TEST(GraspSelection, WristCriterionIsTheAbsoluteDifference) {
  EXPECT_DOUBLE_EQ(wrist_criterion(0.3, 1.0), 0.7);
  EXPECT_DOUBLE_EQ(wrist_criterion(1.0, 0.3), 0.7);
}

TEST(GraspSelection, CostWeighsAlignmentThreeTimesTheWrist) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("only", 10 * kDeg)})};
  const GraspSelector selector(objects, wide_layout(), 0.0, [](const Eigen::Isometry3d&) {
    JointVector q = JointVector::Zero();
    q[6] = -0.5;
    return std::optional<JointVector>(q);
  });
  const auto plan = selector.select({at("box", 0.5, 0.1)}, nullptr);
  ASSERT_TRUE(plan);
  EXPECT_NEAR(plan->cost, 3.0 * 10 * kDeg + 1.0 * 0.5, 1e-9);
}

TEST(GraspSelection, TakesTheUppermostObjectAndItsCheapestGrasp) {
  const std::vector<ObjectModel> objects{
      object_with("box", {tilted_grasp("tilted", 20 * kDeg), tilted_grasp("straight", 0.0)})};
  const GraspSelector selector(objects, wide_layout(), 0.0, anywhere);
  const auto plan =
      selector.select({at("box", 0.4, 0.1), at("box", 0.5, 0.2), at("box", 0.6, 0.15)}, nullptr);
  ASSERT_TRUE(plan);
  EXPECT_DOUBLE_EQ(plan->detection.T_scene_model.translation().z(), 0.2);
  EXPECT_EQ(plan->grasp->name, "straight");
}

TEST(GraspSelection, DiscardsGraspsFromThirtyDegreesOnAndInspectsTheNextLowerObject) {
  const std::vector<ObjectModel> objects{object_with("steep", {tilted_grasp("steep", 30.1 * kDeg)}),
                                         object_with("fine", {tilted_grasp("fine", 29.9 * kDeg)})};
  const GraspSelector selector(objects, wide_layout(), 0.0, anywhere);
  const auto plan = selector.select({at("steep", 0.4, 0.3), at("fine", 0.5, 0.1)}, nullptr);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->detection.model, "fine");
  EXPECT_FALSE(selector.select({at("steep", 0.4, 0.3)}, nullptr));
}

TEST(GraspSelection, ProjectsTheGraspATenthOfAMetreAlongTheApproachVector) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("t", 20 * kDeg)})};
  const GraspSelector selector(objects, wide_layout(), 0.0, anywhere);
  const auto plan = selector.select({at("box", 0.5, 0.1)}, nullptr);
  ASSERT_TRUE(plan);
  const Eigen::Vector3d travel =
      plan->T_world_grasp.translation() - plan->T_world_pregrasp.translation();
  EXPECT_NEAR((travel - 0.1 * plan->T_world_grasp.linear().col(2)).norm(), 0.0, 1e-12);
}

TEST(GraspSelection, KeepsTheFingerTipsAboveTheTable) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("t", 0.0)})};
  const GraspSelector selector(objects, wide_layout(), 0.015, anywhere);
  // The grasp lies 0.03 m above the object's origin.
  EXPECT_TRUE(selector.select({at("box", 0.5, -0.010)}, nullptr));
  EXPECT_FALSE(selector.select({at("box", 0.5, -0.012)}, nullptr));
}

TEST(GraspSelection, LeavesOutWhatTheArmDoesNotReach) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("t", 0.0)})};
  const GraspSelector selector(objects, wide_layout(), 0.0,
                               [](const Eigen::Isometry3d& T) -> std::optional<JointVector> {
                                 if (T.translation().x() > 0.45) return std::nullopt;
                                 return JointVector::Zero();
                               });
  const auto plan = selector.select({at("box", 0.5, 0.3), at("box", 0.4, 0.1)}, nullptr);
  ASSERT_TRUE(plan);
  EXPECT_DOUBLE_EQ(plan->detection.T_scene_model.translation().x(), 0.4);
}

Grasp roomy_grasp(const std::string& name, double room) {
  Grasp grasp = tilted_grasp(name, 0.0);
  grasp.expected_width = grasp.pre_opening - 2.0 * room;
  return grasp;
}

TEST(GraspSelection, ProbabilityOfAMissIsThatOfTheErrorAlongTheJaws) {
  const Grasp grasp = roomy_grasp("g", 0.01);
  Detection detection = at("box", 0.5, 0.1);
  EXPECT_EQ(miss_probability(detection, grasp), 0.0) << "no covariance";
  // One standard deviation of room along the jaws: 31.7 % miss. Errors across do not matter.
  detection.covariance(3, 3) = 1.0;
  EXPECT_EQ(miss_probability(detection, grasp), 0.0);
  detection.covariance(4, 4) = 0.01 * 0.01;
  EXPECT_NEAR(miss_probability(detection, grasp), 0.3173, 1e-4);
}

TEST(GraspSelection, ARotationErrorMovesADistantToolCentre) {
  Grasp grasp = roomy_grasp("g", 0.01);
  grasp.T_object_grasp.translation() << 0.1, 0.0, 0.0;
  Detection detection = at("box", 0.5, 0.1);
  detection.T_scene_model.linear() =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  detection.covariance(2, 2) = 0.1 * 0.1;  // about the vertical: 10 mm at 0.1 m
  EXPECT_NEAR(miss_probability(detection, grasp), 0.3173, 1e-4);
}

TEST(GraspSelection, TheStrategyTakesTheRoomierGraspOfAnUncertainPose) {
  const std::vector<ObjectModel> objects{
      object_with("box", {roomy_grasp("tight", 0.002), roomy_grasp("roomy", 0.015)})};
  Detection detection = at("box", 0.5, 0.1);
  detection.covariance.diagonal().setConstant(0.004 * 0.004);
  ManipulationStrategy strategy;
  const GraspSelector paper(objects, wide_layout(), 0.0, anywhere,
                            GraspSelectionOptions::of(strategy));
  EXPECT_EQ(paper.select({detection}, nullptr)->grasp->name, "tight");
  strategy.uncertainty = true;
  const GraspSelector careful(objects, wide_layout(), 0.0, anywhere,
                              GraspSelectionOptions::of(strategy));
  EXPECT_EQ(careful.select({detection}, nullptr)->grasp->name, "roomy");
}

TEST(GraspSelection, TheStrategyLeavesDoubtfulObjectsForLast) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("t", 0.0)})};
  Detection doubtful = at("box", 0.4, 0.3);
  doubtful.confidence = 0.3;
  Detection sure = at("box", 0.6, 0.1);
  sure.confidence = 0.9;
  ManipulationStrategy strategy;
  strategy.uncertainty = true;
  const GraspSelector careful(objects, wide_layout(), 0.0, anywhere,
                              GraspSelectionOptions::of(strategy));
  EXPECT_EQ(careful.select({doubtful, sure}, nullptr)->detection.confidence, 0.9);
  EXPECT_TRUE(careful.select({doubtful}, nullptr));
  const GraspSelector paper(objects, wide_layout(), 0.0, anywhere);
  EXPECT_EQ(paper.select({doubtful, sure}, nullptr)->detection.confidence, 0.3);
}

TEST(GraspSelection, StraysLieOutsideThePickRegionAndThePlacesAndComeLast) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("only", 0.0)})};
  CellLayout layout;
  layout.pick_region = Eigen::AlignedBox2d(Eigen::Vector2d(0.3, -0.3), Eigen::Vector2d(0.8, 0.3));
  Place place;
  place.p_world = {-0.3, 0.0};
  place.size = {0.2, 0.2};
  layout.places.push_back(place);
  GraspSelectionOptions options;
  options.strays = true;
  const GraspSelector selector(objects, layout, 0.0, anywhere, options);
  const std::vector<Detection> seen{at("box", 0.2, 0.1),  at("box", 0.5, 0.03),
                                    at("box", -0.3, 0.1), at("box", -0.16, 0.1),
                                    at("box", 0.2, 0.3),  at("other", 0.2, 0.05)};
  ASSERT_EQ(selector.strays(seen).size(), 1u);
  EXPECT_EQ(selector.strays(seen)[0].T_scene_model.translation().x(), 0.2);
  const auto plan = selector.select(seen, nullptr);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->detection.T_scene_model.translation().x(), 0.5);
  EXPECT_TRUE(GraspSelector(objects, layout, 0.0, anywhere).strays(seen).empty());
}

TEST(GraspSelection, TheStrategyMayTakeSteepGrasps) {
  const std::vector<ObjectModel> objects{object_with("box", {tilted_grasp("steep", 50 * kDeg)})};
  ManipulationStrategy strategy;
  strategy.steep_grasps = true;
  const GraspSelector steep(objects, wide_layout(), 0.0, anywhere,
                            GraspSelectionOptions::of(strategy));
  EXPECT_TRUE(steep.select({at("box", 0.5, 0.1)}, nullptr));
}

}  // namespace
}  // namespace binpick
