#include "recognition/candidate_pool.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "recognition/depth_rasterizer.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

constexpr Projection kProjection{320, 240, 290.0f, 290.0f, 159.5f, 119.5f};

/// One box in front of a far wall.
class Pool : public ::testing::Test {
 protected:
  Pool() : library_({{"box", testing::make_box({0.15, 0.12, 0.08}), {}}}) {
    truth_.translation() << 0.0f, 0.0f, 0.8f;
    truth_.linear() = (Eigen::AngleAxisf(0.7f, Eigen::Vector3f::UnitX()) *
                       Eigen::AngleAxisf(0.6f, Eigen::Vector3f::UnitY()))
                          .toRotationMatrix();
    observe(truth_);
  }

  void observe(const Eigen::Isometry3f& T) {
    RangeImage image;
    image.intrinsics = {320, 240, 290.0, 290.0, 159.5, 119.5};
    image.depth.assign(320u * 240u, 1.5f);
    DepthRasterizer rasterizer;
    const RenderedModel& r = rasterizer.render(library_.models()[0].render_mesh, T, kProjection);
    for (int v = 0; v < r.height; ++v) {
      for (int u = 0; u < r.width; ++u) {
        if (!r.covers(u, v)) continue;
        image.depth[static_cast<std::size_t>((r.v0 + v) * 320 + r.u0 + u)] = r.depth[r.index(u, v)];
      }
    }
    scene_ = std::make_unique<ObservedScene>(image, SceneScale{0.004, 1e9}, 1, 1);
  }

  Eigen::Isometry3f truth_ = Eigen::Isometry3f::Identity();
  ModelLibrary library_;
  std::unique_ptr<ObservedScene> scene_;
};

TEST_F(Pool, ADetectionThatStandsSurvivesTheSlide) {
  CandidatePool pool(library_, *scene_, calibrated_acceptance(), 0.3, 1);
  pool.add({{0, truth_, 1.0f}}, 5, false);
  ASSERT_EQ(pool.select(true).size(), 1u);
  const double before = pool.selected()[0].log_odds;
  pool.slide_selected();
  ASSERT_EQ(pool.selected().size(), 1u);
  EXPECT_GE(pool.selected()[0].log_odds, before);
}

TEST_F(Pool, ARunnerUpThatIsRightButForAShiftAlongItsOnlyFaceIsFound) {
  Eigen::Isometry3f face_on = Eigen::Isometry3f::Identity();
  face_on.translation() << 0.0f, 0.0f, 0.8f;
  observe(face_on);
  Eigen::Isometry3f shifted = face_on;
  shifted.translation().x() += 0.02f;
  AcceptanceModel by_silhouette;
  by_silhouette.bias = -6.5;
  by_silhouette.terms[static_cast<std::size_t>(Feature::kEdgesMatched)].slope = 8.0;
  CandidatePool pool(library_, *scene_, by_silhouette, 0.3, 1);
  pool.add({{0, shifted, 1.0f}}, 5, false);
  ASSERT_TRUE(pool.select().empty());
  pool.slide_runners_up();
  ASSERT_EQ(pool.candidates().size(), 2u) << "both are kept";
  const Eigen::Vector3f found = pool.candidates()[1].T_camera_model.translation();
  EXPECT_LT((found - face_on.translation()).norm(), 2.0f * 0.8f / 290.0f) << "two pixels";
  EXPECT_EQ(pool.select(/*is_last=*/true).size(), 1u);
  // What is selected needs no runner-up.
  pool.slide_runners_up();
  EXPECT_EQ(pool.candidates().size(), 2u);
}

TEST_F(Pool, RefinedPosesDecideAndThoseThatLoseTheObjectAreUndone) {
  CandidatePool pool(library_, *scene_, calibrated_acceptance(), 0.3, 1);
  pool.add({{0, truth_, 1.0f}}, 5, false);
  ASSERT_EQ(pool.select(true).size(), 1u);
  const Eigen::Isometry3d chosen =
      pool.candidates()[pool.selected()[0].candidate].T_camera_model.cast<double>();
  const double before = pool.selected()[0].log_odds;
  std::vector<RefinedPose> refined(1);
  refined[0].T_camera_model = chosen;
  refined[0].T_camera_model.translation().x() += 0.03;
  pool.judge_refined(refined);
  EXPECT_TRUE(refined[0].T_camera_model.isApprox(chosen));
  EXPECT_EQ(pool.selected()[0].log_odds, before);
  // What is about as credible stays as it was refined, and is judged there.
  refined[0].T_camera_model.translation().z() += 0.001;
  const Eigen::Isometry3d better = refined[0].T_camera_model;
  pool.judge_refined(refined);
  EXPECT_TRUE(refined[0].T_camera_model.matrix() == better.matrix());
  EXPECT_LT(pool.selected()[0].log_odds, before);
}

TEST_F(Pool, WhatMayBeElsewhereIsMovedToWhereItFitsBetter) {
  Eigen::Isometry3f face_on = Eigen::Isometry3f::Identity();
  face_on.translation() << 0.0f, 0.0f, 0.8f;
  observe(face_on);
  Eigen::Isometry3f shifted = face_on;
  shifted.translation().x() += 0.02f;
  AcceptanceModel by_silhouette;
  by_silhouette.bias = 2.0;
  by_silhouette.terms[static_cast<std::size_t>(Feature::kEdgesMatched)].slope = 8.0;
  CandidatePool pool(library_, *scene_, by_silhouette, 0.3, 1);
  pool.add({{0, shifted, 1.0f}}, 5, false);
  ASSERT_EQ(pool.select(/*is_last=*/true).size(), 1u);
  const SelectedCandidate& selected = pool.selected()[0];
  const Candidate& candidate = pool.candidates()[selected.candidate];
  std::vector<RefinedPose> refined(1);
  refined[0].T_camera_model = shifted.cast<double>();
  EXPECT_TRUE(pool.move_elsewhere(refined).empty()) << "a certain pose";
  refined[0].covariance(3, 3) = 0.02 * 0.02;  // along x
  const double before = selected.log_odds;
  EXPECT_EQ(pool.move_elsewhere(refined), std::vector<int>{0});
  EXPECT_GT(selected.log_odds, before);
  EXPECT_LT((candidate.T_camera_model.translation() - face_on.translation()).norm(),
            2.0f * 0.8f / 290.0f)
      << "two pixels";
  refined[0].T_camera_model = candidate.T_camera_model.cast<double>();
  EXPECT_TRUE(pool.move_elsewhere(refined).empty()) << "there is no better place";
}

}  // namespace
}  // namespace binpick
