#include "recognition/table_hit_rate.h"

#include <gtest/gtest.h>

#include "recognition/shapes.h"

namespace binpick {
namespace {

RecognitionModel box() {
  return make_recognition_model("box", testing::make_box({0.15, 0.14, 0.08}),
                                {Eigen::Isometry3d::Identity()});
}

PairTableOptions options() {
  PairTableOptions options;
  options.width = 0.08f;
  options.tolerance = 0.004f;
  options.drop_coplanar = true;
  return options;
}

TEST(TableHitRate, NoisyNormalsMissTheirPairs) {
  const RecognitionModel model = box();
  const double exact = table_hit_rate(model, options(), 0.0);
  EXPECT_GT(exact, 0.1);
  EXPECT_LT(table_hit_rate(model, options(), 0.1), 0.5 * exact);
  EXPECT_GT(table_hit_rate(model, options(), 0.1), 0.0);
}

TEST(TableHitRate, MorePairPointsHitMoreOften) {
  RecognitionModel model = box();
  set_pair_points(model, 12.0f);
  const double coarse = table_hit_rate(model, options(), 0.1);
  set_pair_points(model, 30.0f);
  EXPECT_GT(table_hit_rate(model, options(), 0.1), 3.0 * coarse);
}

TEST(TableHitRate, PairPointsAreAddedUntilItSuffices) {
  RecognitionModel model = box();
  set_pair_points(model, 12.0f);
  const std::size_t before = model.surface.size();
  densify_pair_points(model, options());
  EXPECT_GT(model.surface.size(), before);
  EXPECT_GE(table_hit_rate(model, options(), 0.1), 0.05);
}

}  // namespace
}  // namespace binpick
