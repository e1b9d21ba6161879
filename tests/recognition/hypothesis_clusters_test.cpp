#include "recognition/hypothesis_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "recognition/shapes.h"

namespace binpick {
namespace {

/// One model, a box without symmetries.
class Clusters : public ::testing::Test {
 protected:
  [[nodiscard]] std::vector<Hypothesis> heads(const std::vector<Hypothesis>& hypotheses, int most,
                                              const std::vector<Hypothesis>& known = {}) const {
    return keep_cluster_heads(hypotheses, library_.models(), 0.12f, most, 1, known);
  }
  [[nodiscard]] static Hypothesis at(float x, float angle, float score) {
    Hypothesis hypothesis{0, Eigen::Isometry3f::Identity(), score};
    hypothesis.T_camera_model.translation() << x, 0.0f, 1.0f;
    hypothesis.T_camera_model.linear() =
        Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitZ()).toRotationMatrix();
    return hypothesis;
  }
  /// Poses at one place that are all different.
  [[nodiscard]] static std::vector<Hypothesis> turned(int count, float x, float best) {
    std::vector<Hypothesis> poses;
    for (int i = 0; i < count; ++i) {
      poses.push_back(at(x, 0.3f * static_cast<float>(i), best - static_cast<float>(i)));
    }
    return poses;
  }

  const ModelLibrary library_{{{"box", testing::make_box({0.12, 0.05, 0.03}), {}}}};
};

TEST_F(Clusters, KeepsTheBestOfEach) {
  const std::vector<Hypothesis> kept =
      heads({at(0.0f, 0.0f, 5.0f), at(0.002f, 0.02f, 7.0f), at(0.1f, 0.0f, 6.0f)}, 10);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].score, 7.0f);
  EXPECT_EQ(kept[1].score, 6.0f);
}

TEST_F(Clusters, LeavesOutWhatIsKnown) {
  const std::vector<Hypothesis> kept =
      heads({at(0.0f, 0.0f, 5.0f), at(0.1f, 0.0f, 6.0f)}, 10, {at(0.101f, 0.0f, 0.0f)});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].score, 5.0f);
}

TEST_F(Clusters, WhatScoresLeastIsLookedAtIfItStandsAlone) {
  std::vector<Hypothesis> poses = turned(10, 0.0f, 100.0f);
  poses.push_back(at(0.5f, 0.0f, 1.0f));
  const std::vector<Hypothesis> kept = heads(poses, 4);
  ASSERT_EQ(kept.size(), 4u);
  EXPECT_EQ(kept[0].score, 100.0f);
  EXPECT_EQ(kept[2].score, 98.0f);
  EXPECT_EQ(kept[3].score, 1.0f);
}

TEST_F(Clusters, PlacesShareWhatCanBeLookedAt) {
  std::vector<Hypothesis> poses = turned(10, 0.0f, 100.0f);
  const std::vector<Hypothesis> others = turned(10, 0.5f, 50.0f);
  poses.insert(poses.end(), others.begin(), others.end());
  const std::vector<Hypothesis> kept = heads(poses, 6);
  ASSERT_EQ(kept.size(), 6u);
  EXPECT_EQ(std::count_if(kept.begin(), kept.end(), [](const auto& h) { return h.score > 50.0f; }),
            3);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(),
                             [](const auto& a, const auto& b) { return a.score > b.score; }));
}

}  // namespace
}  // namespace binpick
