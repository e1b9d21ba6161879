#include "recognition/observed_scene.h"

#include <gtest/gtest.h>

#include <numeric>

#include "recognition/acceptance_function.h"
#include "recognition/depth_rasterizer.h"
#include "recognition/projective_alignment.h"
#include "recognition/recognition_model.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

/// A box in front of nothing.
class BoxScene : public ::testing::Test {
 protected:
  BoxScene() : scene_(scan(1), {0.004, 1e9}, 1, 1), box_(measured_pixels(scene_)) {}

  [[nodiscard]] static std::vector<int> measured_pixels(const ObservedScene& scene) {
    std::vector<int> pixels;
    for (int i = 0; i < static_cast<int>(scene.pixels().size()); ++i) {
      if (scene.pixel(i).depth > 0.0f) pixels.push_back(i);
    }
    return pixels;
  }

  [[nodiscard]] static Eigen::Isometry3f pose() {
    Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
    T.translation().z() = 0.8f;
    T.linear() =
        Eigen::AngleAxisf(0.7f, Eigen::Vector3f(1.0f, 0.6f, 0.0f).normalized()).toRotationMatrix();
    return T;
  }
  /// With `fineness` times 320 x 240 pixels.
  [[nodiscard]] RangeImage scan(int fineness) const {
    RangeImage image;
    const int width = 320 * fineness;
    const int height = 240 * fineness;
    image.intrinsics = {
        width, height, 290.0 * fineness, 290.0 * fineness, 0.5 * (width - 1), 0.5 * (height - 1)};
    image.depth.assign(static_cast<std::size_t>(width * height), 0.0f);
    DepthRasterizer rasterizer;
    const RenderedModel& r =
        rasterizer.render(model_.render_mesh, pose(), projection_of(image.intrinsics));
    for (int v = 0; v < r.height; ++v) {
      for (int u = 0; u < r.width; ++u) {
        if (!r.covers(u, v)) continue;
        image.depth[static_cast<std::size_t>((r.v0 + v) * width + r.u0 + u)] =
            r.depth[r.index(u, v)];
      }
    }
    return image;
  }
  [[nodiscard]] FacingCounts count(const Eigen::Isometry3f& T) const {
    return count_facing(scene_, model_, T, 0.002f, 0, model_.test_points.size());
  }
  [[nodiscard]] static int open_leaves(const ObservedScene& scene) {
    int count = 0;
    for (const int leaf : scene.object_leaves()) count += scene.is_open(leaf) ? 1 : 0;
    return count;
  }

  RecognitionModel model_ =
      make_recognition_model("box", testing::make_box({0.15, 0.12, 0.08}), {});
  ObservedScene scene_;
  std::vector<int> box_;  // its pixels
};

TEST_F(BoxScene, WhatIsExplainedIsSearchedNoMore) {
  Eigen::Isometry3f in_front = pose();
  in_front.translation().z() -= 0.05f;
  const FacingCounts before = count(pose());
  const int hidden_before = count(in_front).occluding;
  const int open_before = open_leaves(scene_);
  ASSERT_GT(before.matched, before.facing / 2);
  ASSERT_GT(hidden_before, 0);
  ASSERT_EQ(open_before, static_cast<int>(scene_.object_leaves().size()));

  scene_.set_explained(box_);
  EXPECT_EQ(count(pose()).matched, 0);
  EXPECT_EQ(normal_equations(scene_, model_, pose(), 0.002f, 256).pairs, 0);
  EXPECT_EQ(open_leaves(scene_), 0);
  EXPECT_EQ(count(in_front).occluding, hidden_before);  // it is still there
  EXPECT_EQ(scene_.pixel(box_.front()).flags & ScenePixel::kSupport, 0);

  scene_.set_explained({});
  EXPECT_EQ(count(pose()).matched, before.matched);
  EXPECT_EQ(open_leaves(scene_), open_before);
}

TEST_F(BoxScene, LeavesBetweenThePixelsAreExplainedWithThem) {
  // Working pixels of three by three, of which there is none in many a leaf.
  ObservedScene fine(scan(3), {0.004, 1e9}, 1, 1);
  ASSERT_EQ(fine.projection().width, 320);
  fine.set_explained(measured_pixels(fine));
  EXPECT_LT(open_leaves(fine), static_cast<int>(fine.object_leaves().size()) / 50);
}

TEST_F(BoxScene, WhatIsExplainedReplacesWhatWas) {
  const auto half = static_cast<std::ptrdiff_t>(box_.size() / 2);
  scene_.set_explained({box_.begin(), box_.begin() + half});
  const int upper = count(pose()).matched;
  scene_.set_explained({box_.begin() + half, box_.end()});
  const int lower = count(pose()).matched;
  scene_.set_explained({});
  EXPECT_GT(upper, 0);
  EXPECT_GT(lower, 0);
  EXPECT_EQ(upper + lower, count(pose()).matched);
}

}  // namespace
}  // namespace binpick
