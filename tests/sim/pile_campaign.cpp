#include <gtest/gtest.h>

#include "sim/pile.h"
#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;

class PileCampaign : public ::testing::TestWithParam<Seed> {};

TEST_P(PileCampaign, SettlesAndNobodyEscapes) {
  const auto shared = cell("pile");
  World world(shared, draw_physics(shared->parts.objects, GetParam()));
  const PileReport report = drop_pile(world, GetParam());
  EXPECT_TRUE(report.settled);
  EXPECT_TRUE(report.outside.empty());
  for (int i = 0; i < world.object_count(); ++i) {
    EXPECT_GT(world.object_lowest_point(i), -3e-3) << i;
    EXPECT_LT(world.object_pose(i).translation().z(), 0.4) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PileCampaign, ::testing::Range(Seed{100}, Seed{120}));

}  // namespace
}  // namespace binpick
