#include "recognition/cloud_projection.h"

#include <gtest/gtest.h>

#include <limits>

#include "models/random.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

PointCloud cloud_of(const RangeImage& image, bool organised) {
  PointCloud cloud;
  for (int v = 0; v < image.intrinsics.height; ++v) {
    for (int u = 0; u < image.intrinsics.width; ++u) {
      const Eigen::Vector3d p = image.p_camera(u, v);
      if (p.z() > 0.0) {
        cloud.points.push_back(p.cast<float>());
      } else if (organised) {
        cloud.points.push_back(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
      }
    }
  }
  cloud.width = organised ? image.intrinsics.width : static_cast<int>(cloud.points.size());
  cloud.height = organised ? image.intrinsics.height : 1;
  return cloud;
}

RangeImage frame() {
  const testing::SceneGenerator generator(testing::known_objects());
  return testing::add_kinect_noise(generator.make(testing::SceneKind::kSeparate, 1).clean, {}, 1);
}

TEST(CloudProjection, OrganisedCloudKeepsItsPixels) {
  const RangeImage image = frame();
  const ProjectedCloud projected = project_cloud(cloud_of(image, true), Eigen::Vector3d::Zero());
  EXPECT_NEAR(projected.image.intrinsics.fx, image.intrinsics.fx, 0.5);
  EXPECT_NEAR(projected.image.intrinsics.cy, image.intrinsics.cy, 0.5);
  ASSERT_EQ(projected.image.depth.size(), image.depth.size());
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    ASSERT_EQ(projected.image.depth[i], image.depth[i]);
  }
}

TEST(CloudProjection, OrganisedCloudTellsWhereItsSensorIs) {
  const RangeImage image = frame();
  PointCloud cloud = cloud_of(image, true);
  const Eigen::Vector3d sensor(0.04, -0.02, 0.03);
  for (Eigen::Vector3f& p : cloud.points) p += sensor.cast<float>();
  const ProjectedCloud projected = project_cloud(cloud, Eigen::Vector3d::Zero());
  EXPECT_LT((projected.T_cloud_camera.translation() - sensor).norm(), 1e-3);
  EXPECT_NEAR(projected.image.intrinsics.fx, image.intrinsics.fx, 1.0);
  ASSERT_EQ(projected.image.depth.size(), image.depth.size());
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    ASSERT_NEAR(projected.image.depth[i], image.depth[i], 1e-3);
  }
}

TEST(CloudProjection, TheFarSideOfABodyIsNotSeenThroughItsNearSide) {
  Random random(3);
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i) {
    cloud.points.push_back(
        (Eigen::Vector3d(0.0, 0.0, 1.0) + 0.1 * random.unit_vector()).cast<float>());
  }
  cloud.width = static_cast<int>(cloud.points.size());
  cloud.height = 1;
  const RangeImage image = project_cloud(cloud, Eigen::Vector3d::Zero()).image;
  std::size_t near_side = 0;
  std::size_t far_side = 0;
  for (const float z : image.depth) {
    if (z > 0.0f) ++(z < 0.995f ? near_side : far_side);
  }
  EXPECT_GT(near_side, 4000u);
  EXPECT_LT(static_cast<double>(far_side), 0.2 * static_cast<double>(near_side));
}

TEST(CloudProjection, DoesNotDependOnTheNumberOfThreads) {
  const PointCloud cloud = cloud_of(frame(), false);
  const Eigen::Vector3d viewpoint(0.001, 0.0, 0.0);
  const ProjectedCloud one = project_cloud(cloud, viewpoint, 1);
  EXPECT_EQ(one.image.depth, project_cloud(cloud, viewpoint, 3).image.depth);
}

TEST(CloudProjection, UnorganisedCloudIsSeenFromTheViewpoint) {
  const RangeImage image = frame();
  PointCloud cloud = cloud_of(image, false);
  Eigen::Isometry3d T_cloud_camera = Eigen::Isometry3d::Identity();
  T_cloud_camera.translation() << 1.0, -2.0, 0.5;
  T_cloud_camera.linear() =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, 0.3, -0.5).normalized()).toRotationMatrix();
  for (Eigen::Vector3f& p : cloud.points) p = (T_cloud_camera * p.cast<double>()).cast<float>();
  const ProjectedCloud projected = project_cloud(cloud, T_cloud_camera.translation());
  EXPECT_TRUE(projected.T_cloud_camera.translation().isApprox(T_cloud_camera.translation()));

  // Every pixel holds a point of the cloud, and a pixel holds two points on average.
  std::size_t occupied = 0;
  for (const float z : projected.image.depth) {
    if (z > 0.0f) ++occupied;
  }
  const double density = static_cast<double>(cloud.points.size()) / static_cast<double>(occupied);
  EXPECT_GT(density, 1.5);
  EXPECT_LT(density, 2.6);
  for (std::size_t i = 0; i < cloud.points.size(); i += 501) {
    const Eigen::Vector3d p = projected.T_cloud_camera.inverse() * cloud.points[i].cast<double>();
    const CameraIntrinsics& camera = projected.image.intrinsics;
    const int u = static_cast<int>(std::lround(camera.fx * p.x() / p.z() + camera.cx));
    const int v = static_cast<int>(std::lround(camera.fy * p.y() / p.z() + camera.cy));
    ASSERT_TRUE(u >= 0 && v >= 0 && u < camera.width && v < camera.height);
    EXPECT_GT(projected.image.at(u, v), 0.0f);
    EXPECT_LE(projected.image.at(u, v), 1.02 * p.z());
  }
}

TEST(CloudProjection, NothingGivesAnEmptyImage) {
  EXPECT_TRUE(project_cloud({}, Eigen::Vector3d::Zero()).image.depth.empty());
  PointCloud nans;
  nans.points.assign(100, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  nans.width = 10;
  nans.height = 10;
  EXPECT_TRUE(project_cloud(nans, Eigen::Vector3d::Zero()).image.depth.empty());
}

}  // namespace
}  // namespace binpick
