#include "experiments/referee.h"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/pile.h"

namespace binpick {
namespace {

World single_amicelli() {
  const auto shared =
      make_world_template(load_scene(BINPICK_SOURCE_DIR "/scenes/single_amicelli.yaml"));
  return World(shared, centre_physics(shared->parts.objects));
}

void put(World& world, double x, double y, double z) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, z;
  world.set_object_pose(0, T);
}

const Container& bin_of(const World& world, const std::string& model) {
  for (const Container& container : world.shared().parts.scene.containers) {
    if (container.objects.front() == model) return container;
  }
  throw std::logic_error("no such bin");
}

TEST(Referee, AnObjectAtRestInItsBinIsInPlaceAndOneOnTheTableIsNot) {
  World world = single_amicelli();
  const Referee referee(world);
  ASSERT_TRUE(settle(world, 3.0));
  EXPECT_FALSE(referee.in_designated_place(0));
  EXPECT_EQ(referee.objects_in_pick_region(), std::vector<int>{0});

  const Container& bin = bin_of(world, "amicelli");
  put(world, bin.centre.x(), bin.centre.y(), 0.09);
  world.step();
  EXPECT_FALSE(referee.in_designated_place(0)) << "in the air";
  ASSERT_TRUE(settle(world, 3.0));
  EXPECT_TRUE(referee.in_designated_place(0));
  EXPECT_TRUE(referee.misplaced_objects().empty());
}

TEST(Referee, AnObjectInAnotherKindsBinIsMisplaced) {
  World world = single_amicelli();
  const Referee referee(world);
  const Container& bin = bin_of(world, "bottle");
  put(world, bin.centre.x(), bin.centre.y(), 0.09);
  ASSERT_TRUE(settle(world, 3.0));
  EXPECT_FALSE(referee.in_designated_place(0));
}

TEST(Referee, ADetectionIsCorrectUpToATenthOfTheDiameterAndUpToSymmetry) {
  World world = single_amicelli();
  const Referee referee(world);
  Detection detection;
  detection.model = "amicelli";
  const Eigen::Isometry3d truth = world.object_pose(0);

  detection.T_scene_model =
      truth * Eigen::AngleAxisd(std::numbers::pi / 3.0, Eigen::Vector3d::UnitZ());  // six-fold
  ASSERT_TRUE(referee.match(detection));
  EXPECT_TRUE(referee.match(detection)->correct());
  EXPECT_NEAR(referee.match(detection)->mssd, 0.0, 1e-4);

  const double tenth = 0.1 * referee.match(detection)->diameter;
  detection.T_scene_model = Eigen::Translation3d(0.9 * tenth, 0.0, 0.0) * truth;
  EXPECT_TRUE(referee.match(detection)->correct());
  detection.T_scene_model = Eigen::Translation3d(1.1 * tenth, 0.0, 0.0) * truth;
  EXPECT_FALSE(referee.match(detection)->correct());

  detection.model = "rusk";
  EXPECT_FALSE(referee.match(detection));
}

}  // namespace
}  // namespace binpick
