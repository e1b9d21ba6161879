#include "recognition/recognizer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "models/errors.h"
#include "recognition/pose_metrics.h"
#include "recognition/shapes.h"
#include "recognition/surface_sampling.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

using testing::SceneKind;

std::shared_ptr<const ModelLibrary> library(
    RecognizerSetting setting = RecognizerSetting::kDefault) {
  static const auto as_default = std::make_shared<const ModelLibrary>(testing::known_objects());
  static const auto as_paper =
      std::make_shared<const ModelLibrary>(testing::known_objects(), RecognizerSetting::kPaper);
  return setting == RecognizerSetting::kPaper ? as_paper : as_default;
}

RecognizerOptions options(RecognizerSetting setting, int jobs = 1) {
  RecognizerOptions o;
  o.setting = setting;
  o.jobs = jobs;
  return o;
}

struct Frame {
  testing::SyntheticScene scene;
  RangeImage image;
};

Frame make_frame(SceneKind kind, Seed seed) {
  static const testing::SceneGenerator generator(testing::known_objects());
  Frame frame{generator.make(kind, seed), {}};
  frame.image = testing::add_kinect_noise(frame.scene.clean, {}, seed);
  return frame;
}

/// How many of the true instances have a detection within a tenth of the diameter.
int correct(const Frame& frame, const RecognitionResult& result) {
  int found = 0;
  for (const testing::TrueInstance& instance : frame.scene.instances) {
    const RecognitionModel& model = library()->models()[instance.model];
    for (const Detection& detection : result.detections) {
      if (detection.model == model.name &&
          mssd(detection.T_scene_model, instance.T_camera_model, model.hull, model.symmetries) <
              0.1 * model.diameter) {
        ++found;
        break;
      }
    }
  }
  return found;
}

class RecognizerSettings : public ::testing::TestWithParam<RecognizerSetting> {};

TEST_P(RecognizerSettings, FindsThreeObjectsOnATable) {
  const Frame frame = make_frame(SceneKind::kSeparate, 5);
  const Recognizer recognizer(library(GetParam()), options(GetParam()));
  const RecognitionResult result = recognizer.recognize(frame.image, 1);
  // As printed, without rounds and alignment, one run may miss an object.
  EXPECT_GE(correct(frame, result), GetParam() == RecognizerSetting::kPaper ? 2 : 3);
  EXPECT_EQ(result.support_planes.size(), 1u);
  EXPECT_GT(result.counters.hypotheses, result.counters.accepted);
  EXPECT_GT(result.total_seconds, 0.0);
  for (const Detection& detection : result.detections) {
    EXPECT_GT(detection.visibility, 0.0);
    EXPECT_LE(detection.visibility, 1.0);
    EXPECT_GT(detection.explained_points, 0);
  }
}

TEST_P(RecognizerSettings, ResultDoesNotDependOnTheNumberOfThreads) {
  const Frame frame = make_frame(SceneKind::kPile, 6);
  const RecognitionResult one =
      Recognizer(library(GetParam()), options(GetParam(), 1)).recognize(frame.image, 3);
  for (const int jobs : {2, 5}) {
    const RecognitionResult many =
        Recognizer(library(GetParam()), options(GetParam(), jobs)).recognize(frame.image, 3);
    ASSERT_EQ(one.detections.size(), many.detections.size());
    EXPECT_EQ(one.counters.hypotheses, many.counters.hypotheses);
    EXPECT_EQ(one.counters.accepted, many.counters.accepted);
    for (std::size_t i = 0; i < one.detections.size(); ++i) {
      EXPECT_EQ(one.detections[i].model, many.detections[i].model);
      EXPECT_EQ(one.detections[i].T_scene_model.matrix(),
                many.detections[i].T_scene_model.matrix());
      EXPECT_EQ(one.detections[i].visibility, many.detections[i].visibility);
    }
  }
}

TEST_P(RecognizerSettings, FindsNothingWhereNothingIs) {
  const Recognizer recognizer(library(GetParam()), options(GetParam()));
  const Frame bare_table = make_frame(SceneKind::kEmptyTable, 7);
  EXPECT_TRUE(recognizer.recognize(bare_table.image, 1).detections.empty());

  EXPECT_FALSE(recognizer.recognize(RangeImage{}, 1).note.empty());
  RangeImage unseen = bare_table.image;
  for (float& z : unseen.depth) z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(recognizer.recognize(unseen, 1).detections.empty());
  EXPECT_TRUE(recognizer.recognize(PointCloud{}, Eigen::Vector3d::Zero(), 1).detections.empty());
}

TEST_P(RecognizerSettings, SurvivesAWrongUnit) {
  const Recognizer recognizer(library(GetParam()), options(GetParam()));
  const Frame frame = make_frame(SceneKind::kSeparate, 5);
  for (const float factor : {1000.0f, 0.001f, 1e12f, 1e-12f}) {
    RangeImage image = frame.image;
    for (float& z : image.depth) z *= factor;
    const RecognitionResult result = recognizer.recognize(image, 1);
    EXPECT_TRUE(result.detections.empty());
    EXPECT_FALSE(result.note.empty()) << "factor " << factor;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, RecognizerSettings,
                         ::testing::Values(RecognizerSetting::kPaper, RecognizerSetting::kDefault),
                         [](const auto& setting) {
                           return setting.param == RecognizerSetting::kPaper ? "Paper" : "Default";
                         });

TEST(Recognizer, AnObjectThatIsNoModelIsNotFound) {
  std::vector<ModelSource> without_rusk = testing::known_objects();
  without_rusk.pop_back();
  const Recognizer recognizer(std::make_shared<const ModelLibrary>(without_rusk),
                              options(RecognizerSetting::kDefault));
  const RecognitionResult result =
      recognizer.recognize(make_frame(SceneKind::kSeparate, 5).image, 1);
  EXPECT_EQ(result.detections.size(), 2u);
  for (const Detection& detection : result.detections) EXPECT_NE(detection.model, "rusk");
}

TEST(Recognizer, CloudFrameIsKept) {
  const Frame frame = make_frame(SceneKind::kSeparate, 5);
  Eigen::Isometry3d T_cloud_camera = Eigen::Isometry3d::Identity();
  T_cloud_camera.translation() << 1.0, -2.0, 0.5;
  T_cloud_camera.linear() =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, 0.3, -0.5).normalized()).toRotationMatrix();
  PointCloud cloud;
  for (int v = 0; v < frame.image.intrinsics.height; ++v) {
    for (int u = 0; u < frame.image.intrinsics.width; ++u) {
      const Eigen::Vector3d p = frame.image.p_camera(u, v);
      if (p.z() > 0.0) cloud.points.push_back((T_cloud_camera * p).cast<float>());
    }
  }
  cloud.width = static_cast<int>(cloud.points.size());
  cloud.height = 1;
  const Recognizer recognizer(library(), options(RecognizerSetting::kDefault));
  RecognitionResult result = recognizer.recognize(cloud, T_cloud_camera.translation(), 1);
  for (Detection& detection : result.detections) {
    detection.T_scene_model = T_cloud_camera.inverse() * detection.T_scene_model;
  }
  EXPECT_EQ(correct(frame, result), 3);
  ASSERT_FALSE(result.support_planes.empty());
  const Eigen::Vector3d on_table = T_cloud_camera * frame.scene.clean.image.p_camera(40, 400);
  EXPECT_LT(std::abs(result.support_planes[0].height(on_table)), 0.006);
}

/// `sources` and `image` in another unit of length.
std::pair<std::vector<ModelSource>, RangeImage> scaled(std::vector<ModelSource> sources,
                                                       RangeImage image, double factor) {
  for (ModelSource& source : sources) {
    for (Eigen::Vector3d& p : std::get<TriangleMesh>(source.shape).vertices) p *= factor;
    for (Eigen::Isometry3d& symmetry : source.symmetries) symmetry.translation() *= factor;
  }
  for (float& z : image.depth) z *= static_cast<float>(factor);
  return {std::move(sources), std::move(image)};
}

TEST(Recognizer, TheUnitOfLengthDoesNotMatter) {
  const Frame frame = make_frame(SceneKind::kPile, 6);
  const RecognitionResult in_metres =
      Recognizer(library(), options(RecognizerSetting::kDefault)).recognize(frame.image, 3);
  ASSERT_GT(in_metres.detections.size(), 2u);
  // A power of two changes no rounding: a constant length anywhere would show.
  constexpr double kUnits = 1024.0;
  const auto [sources, image] = scaled(testing::known_objects(), frame.image, kUnits);
  const RecognitionResult other = Recognizer(std::make_shared<const ModelLibrary>(sources),
                                             options(RecognizerSetting::kDefault))
                                      .recognize(image, 3);
  EXPECT_EQ(other.counters.hypotheses, in_metres.counters.hypotheses);
  ASSERT_EQ(other.detections.size(), in_metres.detections.size());
  for (std::size_t i = 0; i < other.detections.size(); ++i) {
    const Eigen::Isometry3d& a = in_metres.detections[i].T_scene_model;
    const Eigen::Isometry3d& b = other.detections[i].T_scene_model;
    EXPECT_EQ(other.detections[i].model, in_metres.detections[i].model);
    EXPECT_LT((a.linear() - b.linear()).norm(), 1e-5);
    EXPECT_LT((kUnits * a.translation() - b.translation()).norm(), 1e-5 * kUnits);
  }
}

TEST(Recognizer, FindsABodyInACloudOfItsWholeSurface) {
  Frame frame;
  frame.scene.instances.resize(1);
  testing::TrueInstance& bottle = frame.scene.instances.front();
  bottle.T_camera_model.translation() << 0.05, -0.1, 0.7;
  bottle.T_camera_model.linear() =
      Eigen::AngleAxisd(1.2, Eigen::Vector3d(1.0, 0.3, -0.5).normalized()).toRotationMatrix();
  PointCloud cloud;
  const ModelSource source = testing::known_objects().front();
  for (const OrientedPoint& point : sample_evenly(std::get<TriangleMesh>(source.shape), 20000)) {
    cloud.points.push_back((bottle.T_camera_model * point.p.cast<double>()).cast<float>());
  }
  cloud.width = static_cast<int>(cloud.points.size());
  cloud.height = 1;
  const Recognizer recognizer(library(), options(RecognizerSetting::kDefault));
  const RecognitionResult result = recognizer.recognize(cloud, Eigen::Vector3d::Zero(), 1);
  EXPECT_EQ(correct(frame, result), 1);
  EXPECT_EQ(result.detections.size(), 1u);
}

TEST(Recognizer, OptionsOutOfRangeAreAllNamed) {
  RecognizerOptions o;
  o.success_probability = 1.0;
  o.visibility = -0.1;
  o.jobs = 0;
  try {
    o.validate();
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("success_probability"), std::string::npos);
    EXPECT_NE(message.find("visibility"), std::string::npos);
    EXPECT_NE(message.find("jobs"), std::string::npos);
  }
  EXPECT_THROW(Recognizer(library(RecognizerSetting::kPaper), RecognizerOptions{}), InputError);
}

TEST(ModelLibrary, RefusesWhatIsNoModel) {
  EXPECT_THROW(ModelLibrary(std::vector<ModelSource>{}), InputError);
  EXPECT_THROW(ModelLibrary({{"empty", TriangleMesh{}}}), InputError);
  EXPECT_THROW(ModelLibrary({{"empty", PointCloud{}}}), InputError);
  const TriangleMesh box = testing::make_box({0.1, 0.1, 0.1});
  EXPECT_THROW(ModelLibrary({{"twice", box}, {"twice", box}}), InputError);
  TriangleMesh broken = box;
  broken.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ModelLibrary({{"broken", broken}}), InputError);
}

}  // namespace
}  // namespace binpick
