#include "recognition/joint_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "recognition/depth_rasterizer.h"
#include "recognition/pose_metrics.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

constexpr Projection kProjection{320, 240, 290.0f, 290.0f, 159.5f, 119.5f};

struct Placed {
  const RecognitionModel* model;
  Eigen::Isometry3f T;
};

/// Bodies in front of a far wall, without noise.
RangeImage picture_of(const std::vector<Placed>& bodies) {
  RangeImage image;
  image.intrinsics = {320, 240, 290.0, 290.0, 159.5, 119.5};
  image.depth.assign(320u * 240u, 1.5f);
  DepthRasterizer rasterizer;
  for (const Placed& body : bodies) {
    const RenderedModel& r = rasterizer.render(body.model->render_mesh, body.T, kProjection);
    for (int v = 0; v < r.height; ++v) {
      for (int u = 0; u < r.width; ++u) {
        float& z = image.depth[static_cast<std::size_t>((r.v0 + v) * 320 + r.u0 + u)];
        if (r.covers(u, v)) z = std::min(z, r.depth[r.index(u, v)]);
      }
    }
  }
  return image;
}

Eigen::Isometry3f at(float x, float z, float tilt) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translation() << x, 0.01f, z;
  T.linear() = (Eigen::AngleAxisf(tilt, Eigen::Vector3f::UnitX()) *
                Eigen::AngleAxisf(0.6f * tilt, Eigen::Vector3f::UnitY()))
                   .toRotationMatrix();
  return T;
}

Eigen::Isometry3f disturbed(const Eigen::Isometry3f& T, float distance, float angle) {
  Eigen::Isometry3f moved = T;
  moved.translation() += Eigen::Vector3f(distance, -distance, 0.5f * distance);
  moved.linear() = Eigen::AngleAxisf(angle, Eigen::Vector3f(0.6f, 0.0f, 0.8f)) * T.linear();
  return moved;
}

const std::vector<RecognitionModel>& boxes() {
  static const std::vector<RecognitionModel> models = {
      make_recognition_model("box", testing::make_box({0.15, 0.12, 0.08}), {})};
  return models;
}

std::vector<RefinedPose> refine(const RangeImage& image, const std::vector<Candidate>& objects,
                                int jobs = 1) {
  const ObservedScene scene(image, {0.004, 1e9}, 1, 1);
  const SensorEstimate sensor = scene.sensor();
  return refine_jointly(boxes(), scene, sensor, 0.0, objects, jobs);
}

TEST(JointRefinement, TwoTouchingBoxesConvergeOnCleanData) {
  const Eigen::Isometry3f left = at(-0.07f, 0.8f, 0.8f);
  const Eigen::Isometry3f right = at(0.06f, 0.85f, 0.9f);
  const RangeImage image = picture_of({{&boxes()[0], left}, {&boxes()[0], right}});
  const std::vector<Candidate> start = {{0, disturbed(left, 0.002f, 0.02f), {}},
                                        {0, disturbed(right, -0.002f, -0.02f), {}}};
  const std::vector<RefinedPose> poses = refine(image, start);
  EXPECT_LT(add(poses[0].T_camera_model, left.cast<double>(), boxes()[0].hull, {}), 0.0007);
  EXPECT_LT(add(poses[1].T_camera_model, right.cast<double>(), boxes()[0].hull, {}), 0.0007);
  const std::vector<RefinedPose> parallel = refine(image, start, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(parallel[i].T_camera_model.matrix(), poses[i].T_camera_model.matrix());
    EXPECT_EQ(parallel[i].covariance, poses[i].covariance);
  }
}

TEST(JointRefinement, WhatHasNotMovedStaysWhileTheOtherIsRefined) {
  const Eigen::Isometry3f left = at(-0.07f, 0.8f, 0.8f);
  const Eigen::Isometry3f right = at(0.06f, 0.85f, 0.9f);
  const RangeImage image = picture_of({{&boxes()[0], left}, {&boxes()[0], right}});
  const ObservedScene scene(image, {0.004, 1e9}, 1, 1);
  const std::vector<Candidate> start = {{0, disturbed(left, 0.002f, 0.02f), {}},
                                        {0, disturbed(right, -0.002f, -0.02f), {}}};
  std::vector<RefinedPose> poses(2);
  poses[0].T_camera_model = left.cast<double>();
  refine_moved(boxes(), scene, scene.sensor(), 0.0, start, std::vector<int>{1}, poses, 1);
  EXPECT_EQ(poses[0].T_camera_model.matrix(), left.cast<double>().matrix());
  EXPECT_TRUE(poses[0].covariance.isZero());
  EXPECT_LT(add(poses[1].T_camera_model, right.cast<double>(), boxes()[0].hull, {}), 0.0007);
  EXPECT_GT(poses[1].covariance(3, 3), 0.0);
}

TEST(JointRefinement, ASingleFaceIsUncertainAlongItself) {
  const Eigen::Isometry3f facing = at(0.0f, 0.8f, 0.0f);
  // Nothing measured round the face: no step of depth fixes the position in its plane.
  RangeImage image = picture_of({{&boxes()[0], facing}});
  for (float& z : image.depth) z = z > 1.0f ? 0.0f : z;
  const Eigen::Matrix<double, 6, 6> open = refine(image, {{0, facing, {}}})[0].covariance;
  EXPECT_GT(open(3, 3), 100.0 * open(5, 5));  // x and y against z
  EXPECT_GT(open(4, 4), 100.0 * open(5, 5));
  EXPECT_GT(open(2, 2), 10.0 * open(0, 0));  // the turn in the plane
  EXPECT_TRUE(open.isApprox(open.transpose()));
  EXPECT_GT(open.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
  // With the wall behind it, silhouettes fix all but leave more doubt along the face.
  const Eigen::Matrix<double, 6, 6> seen =
      refine(picture_of({{&boxes()[0], facing}}), {{0, facing, {}}})[0].covariance;
  EXPECT_LT(seen(3, 3), 0.01 * open(3, 3));
}

TEST(JointRefinement, LeavesAPoseWithoutDataAlone) {
  const RangeImage image = picture_of({});
  const Eigen::Isometry3f nowhere = at(0.0f, 0.5f, 0.4f);
  const RefinedPose pose = refine(image, {{0, nowhere, {}}})[0];
  EXPECT_TRUE(pose.T_camera_model.isApprox(nowhere.cast<double>(), 1e-6));
  EXPECT_GT(pose.covariance(3, 3), 1e-4);
}

}  // namespace
}  // namespace binpick
