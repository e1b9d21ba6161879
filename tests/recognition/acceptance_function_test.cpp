#include "recognition/acceptance_function.h"

#include <gtest/gtest.h>

#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

class AcceptanceFunction : public ::testing::Test {
 protected:
  AcceptanceFunction()
      : sources_(testing::known_objects()),
        scene_(testing::SceneGenerator(sources_).make(testing::SceneKind::kSeparate, 2)),
        observed_(scene_.clean.image, {0.005, 0.054}, 1, 1) {
    for (const ModelSource& source : sources_) {
      models_.push_back(make_recognition_model(source.name, std::get<TriangleMesh>(source.shape),
                                               source.symmetries));
    }
  }

  std::vector<ModelSource> sources_;
  testing::SyntheticScene scene_;
  ObservedScene observed_;
  std::vector<RecognitionModel> models_;
};

TEST_F(AcceptanceFunction, TruePoseIsVisibleAndHidesNothing) {
  for (const testing::TrueInstance& instance : scene_.instances) {
    const Acceptance terms = evaluate_acceptance(observed_, models_[instance.model],
                                                 instance.T_camera_model.cast<float>(), 0.006f);
    // Seen from one side, between a quarter and two thirds of the surface.
    EXPECT_GT(terms.visibility, 0.25);
    EXPECT_LT(terms.visibility, 0.67);
    EXPECT_LT(terms.penalty, 0.05);
    EXPECT_TRUE(terms.accepts(0.15, 0.05));
  }
}

TEST_F(AcceptanceFunction, PoseInFrontOfTheSceneIsPenalised) {
  for (const testing::TrueInstance& instance : scene_.instances) {
    Eigen::Isometry3f T = instance.T_camera_model.cast<float>();
    T.translation() *= 0.8f;
    const Acceptance terms = evaluate_acceptance(observed_, models_[instance.model], T, 0.003f);
    EXPECT_GT(terms.penalty, 0.6);
    EXPECT_FALSE(terms.accepts(0.15, 0.05));
    EXPECT_FALSE(test_in_cascade(observed_, models_[instance.model], T, {0.006f, 0.18f, 0.2f}));
  }
}

TEST_F(AcceptanceFunction, PoseBehindTheSceneIsInvisibleButNotPenalised) {
  for (const testing::TrueInstance& instance : scene_.instances) {
    Eigen::Isometry3f T = instance.T_camera_model.cast<float>();
    T.translation() *= 1.6f;
    const Acceptance terms = evaluate_acceptance(observed_, models_[instance.model], T, 0.003f);
    EXPECT_LT(terms.visibility, 0.05);
    EXPECT_LT(terms.penalty, 0.05);
  }
}

TEST_F(AcceptanceFunction, CascadeAgreesWithTheFullCountWhenItAccepts) {
  for (const testing::TrueInstance& instance : scene_.instances) {
    const RecognitionModel& model = models_[instance.model];
    const Eigen::Isometry3f T = instance.T_camera_model.cast<float>();
    const auto quick = test_in_cascade(observed_, model, T, {0.006f, 0.18f, 0.2f});
    ASSERT_TRUE(quick);
    const FacingCounts full = count_facing(observed_, model, T, 0.006f, 0, 256);
    EXPECT_EQ(quick->facing, full.facing);
    EXPECT_EQ(quick->matched, full.matched);
    EXPECT_EQ(quick->occluding, full.occluding);
    EXPECT_GT(full.matched, 0.7 * full.facing);
  }
}

// Far enough visible, so that nothing but the penalty can tell that it is wrong.
TEST_F(AcceptanceFunction, APoseThatSticksOutIsRejectedByThePenaltyAlone) {
  int tried = 0;
  for (const testing::TrueInstance& instance : scene_.instances) {
    const RecognitionModel& model = models_[instance.model];
    Eigen::Isometry3f T = instance.T_camera_model.cast<float>();
    for (int step = 0; step < 30; ++step) {
      T.translation().x() += 0.002f;
      const FacingCounts counts = count_facing(observed_, model, T, 0.006f, 0, 256);
      if (counts.matched < 0.3 * counts.facing || counts.occluding < 0.3 * counts.facing) continue;
      ++tried;
      EXPECT_FALSE(test_in_cascade(observed_, model, T, {0.006f, 0.18f, 0.2f}));
      EXPECT_TRUE(test_in_cascade(observed_, model, T, {0.006f, 0.18f, 1.0f}));
    }
  }
  EXPECT_GE(tried, 3);
}

TEST_F(AcceptanceFunction, ModelBelowTheTableSinks) {
  for (const testing::TrueInstance& instance : scene_.instances) {
    const RecognitionModel& model = models_[instance.model];
    Eigen::Isometry3f T = instance.T_camera_model.cast<float>();
    EXPECT_FALSE(sinks_into_support(observed_, model, T, 0.01f));
    T.translation() -= 0.05f * observed_.support_planes().front().normal.cast<float>();
    EXPECT_TRUE(sinks_into_support(observed_, model, T, 0.01f));
  }
}

}  // namespace
}  // namespace binpick
