#include "recognition/hypothesis_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "recognition/shapes.h"

namespace binpick {
namespace {

constexpr CameraIntrinsics kCamera{320, 240, 290.0, 290.0, 159.5, 119.5};

Projection projection() { return {320, 240, 290.0f, 290.0f, 159.5f, 119.5f}; }

/// A box seen on three faces, in front of a far wall, without noise.
Eigen::Isometry3f tilted() {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translation() << 0.02f, -0.01f, 0.8f;
  T.linear() = (Eigen::AngleAxisf(0.7f, Eigen::Vector3f::UnitX()) *
                Eigen::AngleAxisf(0.6f, Eigen::Vector3f::UnitY()))
                   .toRotationMatrix();
  return T;
}

RangeImage picture_of(const RecognitionModel& model, const Eigen::Isometry3f& T) {
  RangeImage image;
  image.intrinsics = kCamera;
  image.depth.assign(320u * 240u, 1.5f);
  DepthRasterizer rasterizer;
  const RenderedModel& rendered = rasterizer.render(model.render_mesh, T, projection());
  for (int v = 0; v < rendered.height; ++v) {
    for (int u = 0; u < rendered.width; ++u) {
      if (!rendered.covers(u, v)) continue;
      image.depth[static_cast<std::size_t>((rendered.v0 + v) * 320 + rendered.u0 + u)] =
          rendered.depth[rendered.index(u, v)];
    }
  }
  return image;
}

class Evidence : public ::testing::Test {
 protected:
  static RecognitionModel box(double side) {
    return make_recognition_model("box", testing::make_box({side, 0.12, 0.08}), {});
  }
  static ObservedScene observe(const RangeImage& image) { return {image, {0.004, 1e9}, 1, 1}; }

  RecognitionModel model_ = box(0.15);
  ObservedScene scene_ = observe(picture_of(model_, tilted()));
  SensorEstimate sensor_ = estimate_sensor(scene_);
  EvidenceGatherer gatherer_{scene_, sensor_};
};

int all_verdicts(const HypothesisEvidence& e) {
  return e.matched + e.bad_normal + e.seen_through + e.seen_through_rim + e.near_occluded +
         e.far_occluded + e.missing + e.on_support + e.claimed;
}

TEST_F(Evidence, TruePoseMatchesInsideAndAlongTheSilhouette) {
  const HypothesisEvidence e = gatherer_.gather(model_, tilted());
  EXPECT_EQ(all_verdicts(e), e.rendered);
  EXPECT_GT(e.matched, 0.9 * e.rendered);
  EXPECT_EQ(e.seen_through, 0);
  EXPECT_EQ(e.near_occluded, 0);
  EXPECT_EQ(e.edges_continued, 0);
  EXPECT_GT(e.edges_matched, 0.8 * e.edges);
  EXPECT_NEAR(e.edge_offset, 0.0f, 0.2f);
  EXPECT_GT(e.second_face, 0.05f);
  EXPECT_LT(e.residual_rms, 0.1f);
}

TEST_F(Evidence, PosesInFrontAndBehindAreToldApart) {
  Eigen::Isometry3f T = tilted();
  T.translation().z() -= 0.02f;
  EXPECT_GT(gatherer_.gather(model_, T).seen_through, 500);
  T.translation().z() += 0.025f;
  const HypothesisEvidence behind = gatherer_.gather(model_, T);
  EXPECT_GT(behind.near_occluded, 0.5 * behind.rendered);
  T.translation().z() += 0.2f;
  const HypothesisEvidence far = gatherer_.gather(model_, T);
  EXPECT_GT(far.far_occluded, 0.9 * far.rendered);
  EXPECT_EQ(far.matched, 0);
}

TEST_F(Evidence, AModelSmallerThanTheObjectSeesItGoOn) {
  const RecognitionModel shorter = box(0.10);
  const HypothesisEvidence e = gatherer_.gather(shorter, tilted());
  EXPECT_GT(e.edges_continued, 0.15 * e.edges);
}

TEST_F(Evidence, AModelLargerThanTheObjectIsSeenThrough) {
  const RecognitionModel longer = box(0.20);
  const HypothesisEvidence e = gatherer_.gather(longer, tilted());
  EXPECT_GT(e.seen_through, 0.1 * e.rendered);
  EXPECT_GT(e.edges_missed, 0);
}

TEST_F(Evidence, WhatAnotherClaimsIsNotItsOwn) {
  const HypothesisEvidence own = gatherer_.gather(model_, tilted());
  PixelClaims claims(scene_.pixels().size(), 7);
  const HypothesisEvidence taken = gatherer_.gather(model_, tilted(), &claims, 3);
  EXPECT_EQ(taken.matched, 0);
  EXPECT_EQ(taken.claimed, own.matched + own.bad_normal);
  const HypothesisEvidence again = gatherer_.gather(model_, tilted(), &claims, 7);
  EXPECT_EQ(again.matched, own.matched);
}

TEST_F(Evidence, MissingPixelsAreNeutral) {
  RangeImage image = picture_of(model_, tilted());
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    if (i % 320 > 160) image.depth[i] = 0.0f;
  }
  const ObservedScene half = observe(image);
  EvidenceGatherer gatherer(half, sensor_);
  const HypothesisEvidence e = gatherer.gather(model_, tilted());
  EXPECT_GT(e.missing, 0.3 * e.rendered);
  EXPECT_EQ(e.seen_through + e.near_occluded + e.edges_continued + e.edges_missed, 0);
}

TEST_F(Evidence, ExplainedPixelsAreThoseThatAgree) {
  const HypothesisEvidence e = gatherer_.gather(model_, tilted());
  std::vector<int> pixels;
  gatherer_.explained_pixels(pixels);
  EXPECT_EQ(static_cast<int>(pixels.size()), e.matched + e.bad_normal);
  EXPECT_TRUE(std::is_sorted(pixels.begin(), pixels.end()));
}

}  // namespace
}  // namespace binpick
