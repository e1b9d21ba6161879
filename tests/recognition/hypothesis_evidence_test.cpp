#include "recognition/hypothesis_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "models/random.h"
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
  SensorEstimate sensor_ = scene_.sensor();
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
  EXPECT_EQ(e.edges_seen, e.edges);
  EXPECT_GT(e.edges_matched, 0.8 * e.edges);
  EXPECT_NEAR(e.edge_offset, 0.0f, 0.2f);
  EXPECT_GT(e.second_face, 0.05f);
  EXPECT_LT(e.residual_rms, 0.1f);
}

TEST_F(Evidence, BeforeNothingTheSilhouetteIsOpen) {
  RangeImage image = picture_of(model_, tilted());
  for (float& depth : image.depth) {
    if (depth == 1.5f) depth = 0.0f;
  }
  const ObservedScene alone = observe(image);
  EvidenceGatherer gatherer(alone, sensor_);
  const HypothesisEvidence e = gatherer.gather(model_, tilted());
  EXPECT_EQ(e.edges_matched, 0);
  EXPECT_GT(e.edges_open, 0.8 * e.edges);
  EXPECT_EQ(gatherer_.gather(model_, tilted()).edges_open, 0) << "before a wall";
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

/// A standing cylinder whose nearest line is 0.75 m away.
RecognitionModel cylinder(double radius) {
  return make_recognition_model("cylinder", testing::make_prism(96, radius, 0.15), {});
}
Eigen::Isometry3f standing(float radius) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translation().z() = 0.75f + radius;
  T.linear() = Eigen::AngleAxisf(1.5707963f, Eigen::Vector3f::UnitX()).toRotationMatrix();
  return T;
}

TEST_F(Evidence, AThinCylinderOnTheFrontOfAThickOneSeesItGoOn) {
  const ObservedScene thick = observe(picture_of(cylinder(0.066), standing(0.066f)));
  EvidenceGatherer gatherer(thick, sensor_);
  const HypothesisEvidence e = gatherer.gather(cylinder(0.044), standing(0.044f));
  EXPECT_GT(e.matched, 0.5 * e.rendered);
  EXPECT_GT(e.edges_continued, 0.3 * e.edges);
}

TEST_F(Evidence, NoiseHidesLittleOfASurfaceThatGoesOn) {
  RangeImage image = picture_of(cylinder(0.066), standing(0.066f));
  Random random(5);
  for (float& depth : image.depth) depth += static_cast<float>(0.006 * random.normal());
  const ObservedScene thick = observe(image);
  const SensorEstimate noisy = thick.sensor();
  EvidenceGatherer gatherer(thick, noisy);
  const HypothesisEvidence e = gatherer.gather(cylinder(0.044), standing(0.044f));
  EXPECT_GT(e.edges_continued, 0.5 * e.edges);
}

TEST_F(Evidence, AnOccluderIsNoSurfaceThatGoesOn) {
  RangeImage image = picture_of(cylinder(0.044), standing(0.044f));
  Eigen::Isometry3f in_front = Eigen::Isometry3f::Identity();
  in_front.translation() << 0.08f, 0.0f, 0.6f;  // hides the right side
  const RangeImage occluder = picture_of(box(0.15), in_front);
  std::transform(image.depth.begin(), image.depth.end(), occluder.depth.begin(),
                 image.depth.begin(), [](float a, float b) { return std::min(a, b); });
  const ObservedScene both = observe(image);
  EvidenceGatherer gatherer(both, sensor_);
  const HypothesisEvidence e = gatherer.gather(cylinder(0.044), standing(0.044f));
  EXPECT_GT(e.far_occluded, 0.1 * e.rendered);
  EXPECT_EQ(e.edges_continued, 0);
  EXPECT_LT(e.edges_seen, 0.9 * e.edges);
  EXPECT_GT(e.edges_matched, 0.8 * e.edges_seen);
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

/// Two boxes with a gap of a pixel or two between them.
TriangleMesh make_split_box() {
  TriangleMesh both;
  for (const double side : {-1.0, 1.0}) {
    const TriangleMesh half = testing::make_box({0.073, 0.12, 0.08});
    const auto first = static_cast<std::int32_t>(both.vertices.size());
    for (const Eigen::Vector3d& p : half.vertices) {
      both.vertices.emplace_back(p + Eigen::Vector3d(side * 0.0385, 0.0, 0.0));
    }
    for (const auto& t : half.triangles) {
      both.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  return both;
}

TEST_F(Evidence, ANotchOfTheSilhouetteIsNoPlaceWhereTheSurfaceGoesOn) {
  const RecognitionModel split = make_recognition_model("split", make_split_box(), {});
  const HypothesisEvidence e = gatherer_.gather(split, tilted());
  EXPECT_GT(e.matched, 0.9 * e.rendered);
  EXPECT_EQ(e.edges_continued, 0);
}

TEST_F(Evidence, ASingleFaceIsFixedByItsSilhouetteAlone) {
  Eigen::Isometry3f facing = Eigen::Isometry3f::Identity();
  facing.translation().z() = 0.8f;
  const ObservedScene alone = observe(picture_of(model_, facing));
  EvidenceGatherer gatherer(alone, sensor_);
  const HypothesisEvidence seen = gatherer.gather(model_, facing);
  EXPECT_LT(seen.second_face, 0.01f);
  EXPECT_GT(seen.least_information, 20.0f);
  // The middle of a large wall.
  const RecognitionModel wall =
      make_recognition_model("wall", testing::make_box({0.8, 0.6, 0.08}), {});
  const ObservedScene board = observe(picture_of(wall, facing));
  EvidenceGatherer on_board(board, sensor_);
  const HypothesisEvidence lost = on_board.gather(model_, facing);
  EXPECT_GT(lost.matched, 0.9 * lost.rendered);
  EXPECT_LT(lost.least_information, 1.0f);
}

TEST(Roughness, IsThatOfTheCurvature) {
  constexpr double kRadius = 0.05;
  const RecognitionModel ball = make_recognition_model("ball", testing::make_sphere(kRadius), {});
  const RecognitionModel box =
      make_recognition_model("box", testing::make_box({0.15, 0.12, 0.08}), {});
  ASSERT_EQ(ball.render_mesh.roughness.size(), ball.render_mesh.triangles.size());
  double mean = 0.0;
  for (const float roughness : ball.render_mesh.roughness) mean += static_cast<double>(roughness);
  mean /= static_cast<double>(ball.render_mesh.roughness.size());
  // The mean cosine over a cap of half-angle t is 1 - t^2 / 4 to second order.
  EXPECT_NEAR(mean, 0.25 / (kRadius * kRadius), 0.15 / (kRadius * kRadius));
  EXPECT_LT(*std::max_element(box.render_mesh.roughness.begin(), box.render_mesh.roughness.end()),
            0.5f * static_cast<float>(mean));
}

TEST_F(Evidence, NormalsOfPartsSmallerThanALeafAreNotCompared) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translation().z() = 0.8f;
  const RecognitionModel bead = make_recognition_model("bead", testing::make_sphere(0.012), {});
  const ObservedScene coarse(picture_of(bead, T), {0.01, 1e9}, 1, 1);
  EvidenceGatherer gatherer(coarse, sensor_);
  const HypothesisEvidence e = gatherer.gather(bead, T);
  EXPECT_GT(e.rendered, 30);
  EXPECT_EQ(e.bad_normal, 0);
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
