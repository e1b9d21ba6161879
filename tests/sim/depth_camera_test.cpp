#include "sim/depth_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "sim/pile.h"
#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;
using testing::make_world;

struct RayHit {
  double z = 0.0;  // along the optical axis, 0: nothing
  int geom = -1;
};

// What MuJoCo's ray caster, which shares nothing with the rasterizer, sees in pixel (u, v).
RayHit cast_ray(const World& world, const RangeImage& image, int u, int v) {
  const CameraIntrinsics& k = image.intrinsics;
  const Eigen::Vector3d in_camera((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
  const Eigen::Vector3d direction = image.T_world_camera.linear() * in_camera;
  const Eigen::Vector3d origin = image.T_world_camera.translation();
  const std::array<mjtByte, 6> seen_groups{0, 0, 1, 0, 0, 0};
  RayHit hit;
  const double scale = mj_ray(&world.model(), &world.data(), origin.data(), direction.data(),
                              seen_groups.data(), 1, -1, &hit.geom);
  hit.z = scale > 0.0 ? scale : 0.0;
  return hit;
}

class PileView : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = new World(make_world("pile"));
    camera_ = new DepthCamera(cell("pile"));
    drop_pile(*world_, 3);
    world_->refresh_poses();
  }
  static void TearDownTestSuite() {
    delete camera_;
    delete world_;
  }
  static World* world_;
  static DepthCamera* camera_;
};

World* PileView::world_ = nullptr;
DepthCamera* PileView::camera_ = nullptr;

TEST_F(PileView, DepthAgreesWithRayCasting) {
  const RangeImage image = camera_->ideal(*world_);
  std::vector<double> errors;
  for (int v = 3; v < image.intrinsics.height; v += 7) {
    for (int u = 2; u < image.intrinsics.width; u += 7) {
      const RayHit hit = cast_ray(*world_, image, u, v);
      ASSERT_GT(hit.z, 0.0);
      errors.push_back(std::abs(hit.z - double{image.at(u, v)}));
    }
  }
  std::sort(errors.begin(), errors.end());
  const auto quantile = [&](double share) {
    return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
  };
  EXPECT_LT(quantile(0.5), 5e-6);
  EXPECT_LT(quantile(0.95), 1e-4);
  // Only silhouettes, where the ray may pass what the pixel's centre just misses.
  EXPECT_LT(quantile(0.99), 5e-3);
}

TEST_F(PileView, SegmentationAgreesWithRayCasting) {
  const RangeImage image = camera_->ideal(*world_);
  const SegmentationImage segments =
      camera_->renderer().segmentation(*world_, View::kDepthCamera, 640, 480);
  int compared = 0;
  int different = 0;
  int on_objects = 0;
  for (int v = 3; v < 480; v += 7) {
    for (int u = 2; u < 640; u += 7) {
      const int owner =
          world_->shared()
              .index.geom_object[static_cast<std::size_t>(cast_ray(*world_, image, u, v).geom)];
      int expected = owner;
      if (owner == WorldIndex::kCell) expected = SegmentationImage::kCell;
      if (owner == WorldIndex::kRobot) expected = SegmentationImage::kRobot;
      const int seen = segments.object[static_cast<std::size_t>(v * 640 + u)];
      ++compared;
      on_objects += owner >= 0 ? 1 : 0;
      different += seen != expected ? 1 : 0;
    }
  }
  EXPECT_GT(on_objects, 300);
  EXPECT_LT(different, compared / 200);
}

TEST_F(PileView, ArmHidesNothingOfThePickRegion) {
  const RangeImage image = camera_->ideal(*world_);
  const SegmentationImage segments =
      camera_->renderer().segmentation(*world_, View::kDepthCamera, 640, 480);
  const CellLayout layout = cell_layout(world_->shared().parts.scene);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      if (segments.object[static_cast<std::size_t>(v * 640 + u)] != SegmentationImage::kRobot) {
        continue;
      }
      // Where the ray that ends on the robot would have met the table.
      const Eigen::Vector3d origin = image.T_world_camera.translation();
      const Eigen::Vector3d p_world = image.T_world_camera * image.p_camera(u, v);
      const Eigen::Vector3d ray = p_world - origin;
      const Eigen::Vector2d on_table = (origin - ray * (origin.z() / ray.z())).head<2>();
      EXPECT_FALSE(layout.pick_region.contains(on_table)) << u << ' ' << v;
    }
  }
}

TEST_F(PileView, ImagesDoNotDependOnTheThread) {
  const std::vector<float> here = camera_->ideal(*world_).depth;
  std::vector<float> elsewhere;
  std::thread([&] { elsewhere = DepthCamera(cell("pile")).ideal(*world_).depth; }).join();
  EXPECT_EQ(here, elsewhere);
}

TEST_F(PileView, PointsOfTheTableLieOnTheTable) {
  const RangeImage image = camera_->ideal(*world_);
  const SegmentationImage segments =
      camera_->renderer().segmentation(*world_, View::kDepthCamera, 640, 480);
  std::vector<double> heights;
  for (int v = 200; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      if (segments.object[static_cast<std::size_t>(v * 640 + u)] != SegmentationImage::kCell) {
        continue;
      }
      heights.push_back((image.T_world_camera * image.p_camera(u, v)).z());
    }
  }
  ASSERT_GT(heights.size(), 10000u);
  std::nth_element(heights.begin(), heights.begin() + std::ptrdiff_t(heights.size() / 2),
                   heights.end());
  EXPECT_NEAR(heights[heights.size() / 2], 0.0, 1e-5);
}

TEST(DepthCamera, ServesSeveralWorldsOfItsTemplate) {
  const auto shared = cell("single_bottle");
  DepthCamera camera(shared);
  World with(shared, centre_physics(shared->parts.objects));
  World without(shared, centre_physics(shared->parts.objects));
  without.park_object(0);
  EXPECT_NE(camera.ideal(with).depth, camera.ideal(without).depth);
  EXPECT_EQ(camera.ideal(with).depth, camera.ideal(with).depth);
}

TEST(DepthCamera, LookingDoesNotChangeTheFuture) {
  const auto shared = cell("single_bottle");
  DepthCamera camera(shared);
  const auto run = [&](bool looking) {
    World world(shared, centre_physics(shared->parts.objects));
    world.hold_arm(false);
    for (int i = 0; i < 300; ++i) {
      world.step();
      if (looking) {
        (void)world.T_world_tcp();
        if (i % 50 == 0) (void)camera.ideal(world);
      }
    }
    return world.save_state().numbers;
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(Renderer, RefusesImagesLargerThanItsBuffer) {
  World world = make_world("single_bottle");
  Renderer renderer(cell("single_bottle"), 64, 48);
  EXPECT_THROW((void)renderer.depth(world, View::kDepthCamera, 65, 48), std::invalid_argument);
}

}  // namespace
}  // namespace binpick
