#include "recognition/detection_selection.h"

#include <gtest/gtest.h>

#include <set>

#include "recognition/depth_rasterizer.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

constexpr Projection kProjection{320, 240, 290.0f, 290.0f, 159.5f, 119.5f};

Eigen::Isometry3f at(float x, float y) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translation() << x, y, 0.8f;
  T.linear() = (Eigen::AngleAxisf(0.7f, Eigen::Vector3f::UnitX()) *
                Eigen::AngleAxisf(0.6f, Eigen::Vector3f::UnitY()))
                   .toRotationMatrix();
  return T;
}

/// Two boxes side by side in front of a far wall.
class Selection : public ::testing::Test {
 protected:
  Selection() : scene_(observe(1.5f)), sensor_(scene_->sensor()) {}

  /// The boxes in front of a wall at `background`; 0 for none.
  [[nodiscard]] std::unique_ptr<ObservedScene> observe(float background) const {
    RangeImage image;
    image.intrinsics = {320, 240, 290.0, 290.0, 159.5, 119.5};
    image.depth.assign(320u * 240u, background);
    DepthRasterizer rasterizer;
    for (const Eigen::Isometry3f& T : {left_, right_}) {
      const RenderedModel& r = rasterizer.render(models_[0].render_mesh, T, kProjection);
      for (int v = 0; v < r.height; ++v) {
        for (int u = 0; u < r.width; ++u) {
          if (!r.covers(u, v)) continue;
          image.depth[static_cast<std::size_t>((r.v0 + v) * 320 + r.u0 + u)] =
              r.depth[r.index(u, v)];
        }
      }
    }
    return std::make_unique<ObservedScene>(image, SceneScale{0.004, 1e9}, 1, 1);
  }

  struct Pose {
    int model;
    Eigen::Isometry3f T_camera_model;
  };
  std::vector<SelectedCandidate> select_best(const std::vector<Pose>& poses,
                                             const ObservedScene& scene) const {
    EvidenceGatherer gatherer(scene, sensor_);
    std::vector<Candidate> candidates;
    for (const auto& [model, T] : poses) {
      candidates.push_back(
          {model, T, gatherer.gather(models_[static_cast<std::size_t>(model)], T)});
    }
    DetectionSelection selection(models_, scene, sensor_, calibrated_acceptance(), candidates);
    return selection.select_best();
  }
  std::vector<SelectedCandidate> select_best(const std::vector<Pose>& poses) const {
    return select_best(poses, *scene_);
  }

  std::vector<std::size_t> select(const std::vector<Eigen::Isometry3f>& poses) const {
    std::vector<Pose> of_box;
    for (const Eigen::Isometry3f& T : poses) of_box.push_back({0, T});
    std::vector<std::size_t> chosen;
    for (const SelectedCandidate& s : select_best(of_box)) chosen.push_back(s.candidate);
    return chosen;
  }

  const Eigen::Isometry3f left_ = at(-0.12f, 0.0f);
  const Eigen::Isometry3f right_ = at(0.12f, 0.02f);
  std::vector<RecognitionModel> models_ = {
      make_recognition_model("box", testing::make_box({0.15, 0.12, 0.08}), {})};
  std::unique_ptr<ObservedScene> scene_;
  SensorEstimate sensor_;
};

TEST_F(Selection, EveryInstanceIsChosenOnce) {
  Eigen::Isometry3f beside = left_;
  beside.translation().x() += 0.004f;
  Eigen::Isometry3f turned = left_;  // a half turn that the box does not notice
  turned.linear() *= Eigen::AngleAxisf(3.14159265f, Eigen::Vector3f::UnitZ()).toRotationMatrix();
  const std::vector<std::size_t> chosen = select({beside, left_, turned, right_});
  ASSERT_EQ(chosen.size(), 2u);
  EXPECT_TRUE(std::set<std::size_t>(chosen.begin(), chosen.end()).contains(3u));
}

TEST_F(Selection, PosesThatTheSceneContradictsAreNotChosen) {
  EXPECT_TRUE(select({at(0.0f, 0.0f), at(-0.12f, 0.09f)}).empty());
  EXPECT_TRUE(select({}).empty());
}

TEST_F(Selection, FeaturesAreThoseBesideTheSetThatStood) {
  // A twin of another name loses, is tried in an exchange, and loses again.
  models_.push_back(models_.front());
  EvidenceGatherer gatherer(*scene_, sensor_);
  std::vector<Candidate> candidates;
  for (const int model : {0, 1}) {
    candidates.push_back({model, left_, gatherer.gather(models_[0], left_)});
  }
  DetectionSelection selection(models_, *scene_, sensor_, calibrated_acceptance(), candidates);
  const std::vector<SelectedCandidate> selected = selection.select_best();
  ASSERT_EQ(selected.size(), 1u);
  const std::size_t chosen = selected[0].candidate;
  constexpr auto kClaimed = static_cast<std::size_t>(Feature::kClaimed);
  EXPECT_EQ(selection.decided_features()[chosen][kClaimed], 0.0);
  EXPECT_GT(selection.decided_features()[1 - chosen][kClaimed], 0.9);
}

TEST_F(Selection, RememberedJudgementsAreThoseOfAFreshSelectionOnThreeThreads) {
  EvidenceGatherer gatherer(*scene_, sensor_);
  std::vector<Candidate> candidates;
  JudgementMemory memory;
  // One after the other, so that every selection but the first remembers; chosen ones overlap.
  for (const Eigen::Isometry3f& T :
       {at(-0.112f, 0.006f), at(-0.1f, 0.03f), left_, right_, at(0.118f, 0.024f), at(0.0f, 0.0f)}) {
    candidates.push_back({0, T, gatherer.gather(models_[0], T)});
    DetectionSelection remembering(models_, *scene_, sensor_, calibrated_acceptance(), candidates,
                                   std::move(memory));
    DetectionSelection fresh(models_, *scene_, sensor_, calibrated_acceptance(), candidates, {},
                             /*jobs=*/3);
    const std::vector<SelectedCandidate> a = remembering.select_best();
    const std::vector<SelectedCandidate> b = fresh.select_best();
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].candidate, b[i].candidate);
      EXPECT_EQ(a[i].features, b[i].features);
      EXPECT_EQ(a[i].margin, b[i].margin);
      EXPECT_EQ(a[i].pixels, b[i].pixels);
    }
    EXPECT_EQ(remembering.decided_features(), fresh.decided_features());
    memory = remembering.release_memory();
  }
  EXPECT_GT(memory[2].judgements.size(), 0u);
}

TEST_F(Selection, BetweenRoundsOnlyWhatIsClearIsChosen) {
  AcceptanceModel indifferent;  // more likely right than wrong, but not by much
  indifferent.bias = 1.0;
  indifferent.least_probability = 0.9;
  EvidenceGatherer gatherer(*scene_, sensor_);
  const std::vector<Candidate> candidates = {{0, left_, gatherer.gather(models_[0], left_)}};
  DetectionSelection selection(models_, *scene_, sensor_, indifferent, candidates);
  EXPECT_TRUE(selection.select_clear().empty());
  EXPECT_EQ(selection.select_best().size(), 1u);
}

TEST_F(Selection, WhatAnotherExplainsAsWellHasNoMargin) {
  const std::vector<SelectedCandidate> alone = select_best({{0, left_}, {0, right_}});
  ASSERT_EQ(alone.size(), 2u);
  for (const SelectedCandidate& s : alone) EXPECT_NEAR(s.margin, s.log_odds, 1e-9);
  // Its own neighbourhood is no rival, but a twin of another name is.
  Eigen::Isometry3f beside = left_;
  beside.translation().x() += 0.004f;
  models_.push_back(models_.front());
  const std::vector<SelectedCandidate> rivals =
      select_best({{0, left_}, {0, beside}, {1, left_}, {0, right_}});
  ASSERT_EQ(rivals.size(), 2u);
  for (const SelectedCandidate& s : rivals) {
    EXPECT_NEAR(s.margin, s.candidate == 3 ? s.log_odds : 0.0, 1e-9);
  }
}

TEST_F(Selection, DilationIsReadOffCredibleCandidates) {
  EvidenceGatherer gatherer(*scene_, sensor_);
  Candidate candidate{0, left_, gatherer.gather(models_[0], left_)};
  candidate.evidence.edge_offset = 1.5f;
  const std::vector<Candidate> candidates(3, candidate);
  EXPECT_EQ(estimate_dilation(candidates, calibrated_acceptance()), 1.5);
  EXPECT_EQ(estimate_dilation({}, calibrated_acceptance(), 1, 0.25), 0.25);
}

}  // namespace
}  // namespace binpick
