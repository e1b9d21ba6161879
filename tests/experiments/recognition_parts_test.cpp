#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "experiments/recognition_judgement.h"
#include "experiments/recognition_objects.h"
#include "experiments/recognition_scenes.h"
#include "experiments/recognition_sensor.h"
#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "sim/mesh_asset.h"

namespace binpick {
namespace {

const TriangleMesh kCube = box_mesh({0.1, 0.1, 0.1}, Eigen::Vector3d::Zero());

/// A plate `z` away, and nothing beyond column `columns`.
RangeImage plate(double z, int columns) {
  RangeImage image;
  image.intrinsics = {320, 240, 300.0, 300.0, 159.5, 119.5};
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) image.depth.push_back(u < columns ? static_cast<float>(z) : 0.0f);
  }
  return image;
}

TrueObject cube_at(double z) {
  TrueObject object;
  object.model = "cube";
  object.T_camera_model.translation().z() = z;
  return object;
}

TEST(SurfaceVisibility, ACubeSeenSquarelyShowsOneFaceOfSix) {
  TrueObject cube = cube_at(1.05);
  SurfaceVisibility(kCube).judge(plate(1.0, 320), cube);  // the plate is its front face
  EXPECT_NEAR(cube.visible_share, 1.0, 0.001);
  EXPECT_NEAR(cube.occlusion, 5.0 / 6.0, 0.02);
}

TEST(SurfaceVisibility, WhatStandsBeforeItOccludesIt) {
  TrueObject cube = cube_at(1.05);
  RangeImage image = plate(1.0, 320);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 160; ++u) image.depth[std::size_t(v) * 320 + std::size_t(u)] = 0.8f;
  }
  SurfaceVisibility(kCube).judge(image, cube);
  EXPECT_NEAR(cube.visible_share, 0.5, 0.06);
  EXPECT_NEAR(cube.occlusion, 11.0 / 12.0, 0.02);
}

TEST(SurfaceVisibility, WhatLeavesTheImageIsNotSeen) {
  TrueObject cube = cube_at(1.05);
  cube.T_camera_model.translation().x() = 2.0;
  SurfaceVisibility(kCube).judge(plate(1.0, 320), cube);
  EXPECT_EQ(cube.visible_share, 0.0);
  EXPECT_EQ(cube.occlusion, 1.0);
}

TEST(RecognitionSensor, SilhouettesGrowByTheirPixelsOverWhatIsBehind) {
  RangeImage image = plate(1.0, 320);
  image.depth[120 * 320 + 160] = 0.8f;
  dilate_silhouettes(image, 2);
  for (int v = 100; v < 140; ++v) {
    for (int u = 140; u < 180; ++u) {
      const bool grown = std::abs(v - 120) <= 2 && std::abs(u - 160) <= 2;
      EXPECT_FLOAT_EQ(image.at(u, v), grown ? 0.8f : 1.0f) << u << ' ' << v;
    }
  }
}

TEST(RecognitionSensor, SlopesDoNotGrow) {
  RangeImage image = plate(1.0, 320);
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    image.depth[i] = 1.0f + 0.002f * static_cast<float>(i % 320);
  }
  const std::vector<float> before = image.depth;
  dilate_silhouettes(image, 2);
  EXPECT_EQ(image.depth, before);
}

TEST(RecognitionSensor, GaussianNoiseHasItsDeviationInEveryCoordinate) {
  RecognitionConditions conditions;
  conditions.sensor = "gaussian";
  conditions.gaussian = 0.004;
  const RangeImage ideal = plate(1.0, 320);
  const auto cloud = std::get<PointCloud>(measure(ideal, conditions, 0.5, 7));
  ASSERT_EQ(cloud.points.size(), ideal.depth.size());
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d p = ideal.p_camera(int(i % 320), int(i / 320));
    squares += (cloud.points[i].cast<double>() - p).cwiseAbs2();
  }
  const Eigen::Vector3d sigma = (squares / double(cloud.points.size())).cwiseSqrt();
  EXPECT_LT((sigma - Eigen::Vector3d::Constant(0.002)).cwiseAbs().maxCoeff(), 0.00004);
}

TEST(RecognitionSensor, EachSensorLosesAndMovesPoints) {
  RecognitionConditions conditions;
  RangeImage image = plate(0.9, 320);
  image.depth[120 * 320 + 160] = 0.7f;
  for (const char* sensor : {"kinect", "laser"}) {
    conditions.sensor = sensor;
    const auto first = std::get<RangeImage>(measure(image, conditions, 0.5, 7));
    const auto again = std::get<RangeImage>(measure(image, conditions, 0.5, 7));
    EXPECT_EQ(first.depth, again.depth);
    EXPECT_NE(first.depth, image.depth);
    EXPECT_LT(point_count(first), point_count(image));
    EXPECT_GT(point_count(first), point_count(image) / 2);
  }
  conditions.sensor = "exact";
  EXPECT_EQ(std::get<RangeImage>(measure(image, conditions, 0.5, 7)).depth, image.depth);
}

TEST(RecognitionSensor, WhatShowsNoObjectCanBeCutAway) {
  RangeImage image = plate(0.9, 320);
  SegmentationImage owners;
  owners.object.assign(image.depth.size(), -1);
  owners.object[5000] = 0;
  owners.object[6000] = 3;
  image.depth[6000] = 0.0f;  // not measured
  keep_objects_only(image, owners);
  EXPECT_EQ(point_count(image), 1u);
  EXPECT_GT(image.depth[5000], 0.0f);
}

TEST(RecognitionSensor, LightFromBesideTheCameraLeavesShadowsAndNothingElse) {
  RecognitionConditions conditions;
  RangeImage image = plate(1.0, 320);
  for (int v = 110; v < 130; ++v) {
    for (int u = 150; u < 170; ++u) image.depth[std::size_t(v) * 320 + std::size_t(u)] = 0.8f;
  }
  conditions.sensor = "laser";  // its light comes from below
  const RangeImage by_laser = lit(image, conditions);
  conditions.sensor = "kinect";  // its light comes from the right
  const RangeImage by_kinect = lit(image, conditions);
  conditions.sensor = "exact";
  EXPECT_EQ(lit(image, conditions).depth, image.depth);
  EXPECT_EQ(by_laser.at(160, 100), 0.0f);
  EXPECT_GT(by_laser.at(140, 120), 0.0f);
  EXPECT_EQ(by_kinect.at(147, 120), 0.0f);
  EXPECT_GT(by_kinect.at(160, 100), 0.0f);
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    EXPECT_TRUE(by_laser.depth[i] == 0.0f || by_laser.depth[i] == image.depth[i]) << i;
  }
}

ObjectModel cube_model() {
  ObjectModel model;
  model.name = "cube";
  model.mesh = kCube;
  model.symmetries = {Eigen::Isometry3d::Identity()};
  return model;
}

Detection detection_at(double z) { return {"cube", cube_at(z).T_camera_model, 0, 0, 0, 0, {}}; }

TEST(RecognitionJudge, EachObjectIsFoundOnceAndTheRestIsFalse) {
  const RecognitionJudge judge({cube_model()});
  const std::vector<TrueObject> objects{cube_at(1.0), cube_at(2.0)};
  // Twice the first, the better one later; one that is 2 cm off; none near the second.
  const std::vector<Detection> detections{detection_at(1.004), detection_at(1.001),
                                          detection_at(1.02)};
  const RecognitionJudgement result = judge.judge(detections, objects);
  ASSERT_EQ(result.matches.size(), 1U);
  EXPECT_EQ(result.matches.front().detection, 1U);
  EXPECT_NEAR(result.match_of(0)->mssd, 0.001, 1e-6);
  EXPECT_NEAR(result.match_of(0)->error.translation, 0.001, 1e-9);
  EXPECT_EQ(result.match_of(1), nullptr);
  EXPECT_EQ(result.false_positives, 2U);
}

TEST(RecognitionJudge, CountsSymmetricPosesAsEqual) {
  ObjectModel model = cube_model();
  const Eigen::Isometry3d turned(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  Detection detection = detection_at(1.0);
  detection.T_scene_model = detection.T_scene_model * turned;
  const std::vector<TrueObject> objects{cube_at(1.0)};
  const auto found = [&] {
    return RecognitionJudge({model}).judge(std::vector{detection}, objects).matches.size();
  };
  EXPECT_EQ(found(), 0U);
  model.symmetries.push_back(turned);
  EXPECT_EQ(found(), 1U);
}

TEST(RecognitionObjects, ToysCollideAsClosedPatchesThatCoverThem) {
  const ObjectModel ram = recognition_object("ram");
  EXPECT_GE(ram.collision.size(), 4U);
  Eigen::AlignedBox3d box;
  for (const TriangleMesh& patch : ram.collision) {
    EXPECT_TRUE(is_watertight(patch));
    EXPECT_GT(volume(patch), 0.0);
    box.extend(bounding_box(patch));
  }
  EXPECT_TRUE(box.isApprox(bounding_box(ram.mesh)));
  EXPECT_EQ(toy_files().size(), 4U);
}

TEST(RecognitionObjects, ForeignOnesHaveTheirSizesAndUnknownNamesAreRefused) {
  EXPECT_NEAR(volume(recognition_object("can").mesh), M_PI * 0.033 * 0.033 * 0.115, 4e-6);
  EXPECT_NEAR(volume(recognition_object("carton").mesh), 0.07 * 0.07 * 0.195, 1e-9);
  EXPECT_EQ(recognition_object("rusk").symmetries.size(), 8U);
  EXPECT_THROW((void)recognition_object("unicorn"), InputError);
}

}  // namespace
}  // namespace binpick
