#include "control/grasp_clearance.h"

#include <gtest/gtest.h>

#include "models/gripper_description.h"

namespace binpick {
namespace {

/// A camera 1 m above the table that looks straight down and sees `p_world` in its one pixel.
RangeImage view_of(const Eigen::Vector3d& p_world) {
  RangeImage image;
  image.intrinsics = {1, 1, 500.0, 500.0, 0.0, 0.0};
  image.T_world_camera.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  image.T_world_camera.translation() << p_world.x(), p_world.y(), 1.0;
  image.depth = {static_cast<float>(1.0 - p_world.z())};
  return image;
}

ObjectModel small_box() {
  ObjectModel object;
  object.name = "box";
  for (const double x : {-0.02, 0.02}) {
    for (const double y : {-0.02, 0.02}) {
      for (const double z : {-0.02, 0.02}) object.mesh.vertices.emplace_back(x, y, z);
    }
  }
  Grasp grasp;
  grasp.T_object_grasp.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;  // straight down, jaws along y
  grasp.pre_opening = 0.08;
  object.grasps = {grasp};
  return object;
}

class GraspClearanceTest : public ::testing::Test {
 protected:
  GraspPlan plan() const {
    GraspPlan plan;
    plan.detection.T_scene_model.translation() << 0.5, 0.0, 0.10;
    plan.object = &object_;
    plan.grasp = &object_.grasps.front();
    plan.T_world_grasp = plan.detection.T_scene_model * plan.grasp->T_object_grasp;
    return plan;
  }
  int obstruction_by(const Eigen::Vector3d& p_from_object) {
    const Eigen::Vector3d p_world = plan().detection.T_scene_model * p_from_object;
    return GraspClearance(view_of(p_world), gripper_, 0.0, 0.003, 1).obstructing_points(plan());
  }

  GripperDescription gripper_ = load_gripper();
  ObjectModel object_ = small_box();
  double finger_ = 0.04 + 0.5 * gripper_.finger_thickness;  ///< y of a finger's middle
};

TEST_F(GraspClearanceTest, CountsWhatStandsUnderAFinger) {
  EXPECT_EQ(obstruction_by({0.0, finger_, 0.0}), 1);
  EXPECT_EQ(obstruction_by({0.0, -finger_, 0.05}), 1) << "swept on the way down";
}

TEST_F(GraspClearanceTest, IgnoresWhatTheFingersPass) {
  EXPECT_EQ(obstruction_by({0.0, 0.03, 0.0}), 0) << "between the jaws";
  EXPECT_EQ(obstruction_by({0.0, 0.09, 0.0}), 0) << "outside the finger";
  EXPECT_EQ(obstruction_by({0.05, finger_, 0.0}), 0) << "beside the pad";
  EXPECT_EQ(obstruction_by({0.0, finger_, -0.03}), 0) << "below the tips";
}

TEST_F(GraspClearanceTest, CountsWhatTheHousingWouldMeet) {
  EXPECT_EQ(obstruction_by({0.0, 0.0, gripper_.finger_length - gripper_.tip_beyond_tcp + 0.02}), 1);
}

TEST_F(GraspClearanceTest, TheTargetIsNotInItsOwnWay) {
  EXPECT_EQ(obstruction_by({0.0, 0.0, 0.02}), 0);
}

TEST_F(GraspClearanceTest, TheTableIsNoObstacle) {
  EXPECT_EQ(obstruction_by({0.0, finger_, -0.095}), 0);
}

TEST_F(GraspClearanceTest, AKnownNeighbourStandsInTheWayWithTheSidesThatNobodySaw) {
  const ObjectModel bottle = load_known_object("bottle");
  Detection neighbour;
  neighbour.model = bottle.name;
  neighbour.T_scene_model = plan().detection.T_scene_model;
  neighbour.T_scene_model.translation().y() += 0.07;
  GraspClearance clearance(view_of({5.0, 5.0, 0.5}), gripper_, 0.0);
  EXPECT_EQ(clearance.obstructing_points(plan()), 0);
  clearance.add_object(neighbour, bottle);
  EXPECT_GT(clearance.obstructing_points(plan()), 20);
}

TEST_F(GraspClearanceTest, AKnownObjectIsNotInTheWayOfItsOwnGrasp) {
  const ObjectModel bottle = load_known_object("bottle");
  object_.grasps.front().pre_opening = 0.05;  // less than the bottle is deep
  GraspPlan own = plan();
  own.detection.model = bottle.name;
  GraspClearance clearance(view_of({5.0, 5.0, 0.5}), gripper_, 0.0);
  clearance.add_object(own.detection, bottle);
  EXPECT_EQ(clearance.obstructing_points(own), 0);
  Detection twin = own.detection;
  twin.T_scene_model.translation().x() += 1e-3;
  clearance.add_object(twin, bottle);
  EXPECT_GT(clearance.obstructing_points(own), 0);
}

/// A camera 1 m above (0.5, 0) that looks straight down on a level surface.
RangeImage level_view(double height) {
  RangeImage image = view_of({0.5, 0.0, 0.0});
  image.intrinsics = {200, 200, 300.0, 300.0, 99.5, 99.5};
  image.depth.assign(200 * 200, static_cast<float>(1.0 - height));
  return image;
}

TEST_F(GraspClearanceTest, TellsHowMuchOfTheFingersSpaceLiesInShadow) {
  EXPECT_EQ(GraspClearance(level_view(0.0), gripper_, 0.0).hidden_share(plan()), 0.0);
  EXPECT_EQ(GraspClearance(level_view(0.4), gripper_, 0.0).hidden_share(plan()), 1.0);
  // Tips 0.085 above the table: three of seven rings lie more than 1 cm below 0.1251.
  EXPECT_NEAR(GraspClearance(level_view(0.1251), gripper_, 0.0).hidden_share(plan()), 4.0 / 7.0,
              1e-9);
}

TEST_F(GraspClearanceTest, GivesTheMeasuredPointsOfARegion) {
  const Eigen::Vector3d p_world(0.52, 0.03, 0.11);
  const GraspClearance clearance(view_of(p_world), gripper_, 0.0);
  const Eigen::AlignedBox2d around(Eigen::Vector2d(0.5, 0.0), Eigen::Vector2d(0.6, 0.1));
  const auto points = clearance.points_within(around);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_LT((points.front() - p_world).norm(), 1e-6);
  const Eigen::AlignedBox2d beside(Eigen::Vector2d(0.6, 0.0), Eigen::Vector2d(0.7, 0.1));
  EXPECT_TRUE(clearance.points_within(beside).empty());
}

}  // namespace
}  // namespace binpick
