#include "sim/pile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::make_world;
using testing::step_for;

TEST(Pile, SettlesInsideThePickRegionWithoutSinking) {
  World world = make_world("pile");
  const PileReport report = drop_pile(world, 1);
  EXPECT_TRUE(report.settled);
  EXPECT_TRUE(report.outside.empty());
  for (int i = 0; i < world.object_count(); ++i) {
    EXPECT_FALSE(world.object_parked(i));
    EXPECT_GT(world.object_lowest_point(i), -3e-3) << i;
  }
  for (int contact = 0; contact < world.data().ncon; ++contact) {
    EXPECT_GT(world.data().contact[contact].dist, -2e-3);
  }
}

TEST(Pile, StaysAtRest) {
  World world = make_world("pile");
  drop_pile(world, 2);
  std::vector<Eigen::Vector3d> before;
  for (int i = 0; i < world.object_count(); ++i) {
    before.push_back(world.object_pose(i).translation());
  }
  step_for(world, 1.0);
  for (int i = 0; i < world.object_count(); ++i) {
    EXPECT_LT((world.object_pose(i).translation() - before[std::size_t(i)]).norm(), 3e-3) << i;
  }
}

TEST(Pile, SameSeedGivesTheSamePileBitForBit) {
  World first = make_world("pile");
  World second = make_world("pile");
  step_for(second, 0.05);
  drop_pile(first, 5);
  drop_pile(second, 5);
  for (int i = 0; i < first.object_count(); ++i) {
    EXPECT_EQ(first.object_pose(i).matrix(), second.object_pose(i).matrix()) << i;
  }
  drop_pile(second, 6);
  EXPECT_NE(first.object_pose(0).matrix(), second.object_pose(0).matrix());
}

TEST(Pile, FrameKeepsObjectsInUntilItIsTakenAway) {
  World world = make_world("pile");
  const PileRecipe& recipe = world.shared().parts.scene.pile;
  for (int i = 0; i < world.object_count(); ++i) world.park_object(i);
  world.set_frame_present(true);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(recipe.centre.x(), recipe.centre.y(), 0.1);
  world.set_object_pose(0, T);
  const int body = world.shared().index.object_body[0];
  world.set_body_force(body, {0.0, 12.0, 0.0});
  step_for(world, 1.0);
  EXPECT_LT(world.object_pose(0).translation().y(), recipe.centre.y() + 0.5 * recipe.frame_size);
  world.set_frame_present(false);
  step_for(world, 0.5);
  EXPECT_GT(world.object_pose(0).translation().y(), recipe.centre.y() + 0.5 * recipe.frame_size);
}

TEST(Containers, HoldWhatIsLetGoOverTheirSlots) {
  World world = make_world("pile");
  const CellLayout layout = cell_layout(world.shared().parts.scene);
  Random random(12);
  std::vector<std::pair<int, const Place*>> placed;
  for (const Place& place : layout.places) {
    std::size_t slot = 0;
    for (int i = 0; i < world.object_count(); ++i) {
      const std::string& name = world.object_model(i).name;
      if (std::find(place.objects.begin(), place.objects.end(), name) == place.objects.end()) {
        continue;
      }
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation().head<2>() = place.slots[slot++ % place.slots.size()];
      T.translation().z() = 0.09;
      if (place.rim_height > 0.0) {
        T.linear() = (Eigen::AngleAxisd(random.uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitX()))
                         .toRotationMatrix();
      } else {
        T.translation().z() = 0.06;
      }
      world.set_object_pose(i, T);
      placed.emplace_back(i, &place);
      step_for(world, 0.6);
    }
  }
  ASSERT_EQ(placed.size(), 7u);
  EXPECT_TRUE(settle(world, 5.0));
  for (const auto& [object, place] : placed) {
    const Container& container =
        world.shared().parts.scene.containers[std::size_t(place - layout.places.data())];
    const Eigen::Vector2d offset =
        world.object_pose(object).translation().head<2>() - container.centre;
    EXPECT_TRUE((offset.cwiseAbs().array() < 0.5 * container.size.array()).all())
        << container.name << ' ' << offset.transpose();
  }
}

}  // namespace
}  // namespace binpick
