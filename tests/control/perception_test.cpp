#include "control/perception.h"

#include <gtest/gtest.h>

namespace binpick {
namespace {

Detection seen(const std::string& model, double x, double confidence) {
  Detection detection;
  detection.model = model;
  detection.T_scene_model.translation() << x, 0.0, 0.1;
  detection.confidence = confidence;
  return detection;
}

TEST(MergeLooks, KeepsTheMoreConfidentOfTwoPosesOfOneObject) {
  const auto merged = merge_looks({seen("box", 0.50, 0.4)}, {seen("box", 0.51, 0.8)});
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged.front().confidence, 0.8);
  EXPECT_EQ(merge_looks({seen("box", 0.50, 0.8)}, {seen("box", 0.51, 0.4)}).front().confidence,
            0.8);
}

TEST(MergeLooks, KeepsWhatOnlyOneLookFound) {
  const auto merged =
      merge_looks({seen("box", 0.5, 0.4)}, {seen("box", 0.6, 0.8), seen("bottle", 0.5, 0.7)});
  ASSERT_EQ(merged.size(), 3u);
}

TEST(MergeLooks, TwoNeighboursInOneLookStayTwo) {
  EXPECT_EQ(merge_looks({}, {seen("box", 0.50, 0.4), seen("box", 0.52, 0.8)}).size(), 2u);
}

}  // namespace
}  // namespace binpick
