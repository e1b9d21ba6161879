// Scenes and models that hold nothing to find, one row each: an honest empty result or one
// InputError, soon, never a crash.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <ostream>

#include "message_of.h"
#include "models/errors.h"
#include "models/random.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

PointCloud cloud_of(std::vector<Eigen::Vector3f> points, int height = 1) {
  PointCloud cloud;
  cloud.width = static_cast<int>(points.size()) / height;
  cloud.height = points.empty() ? 0 : height;
  cloud.points = std::move(points);
  return cloud;
}

/// A flat square of 0.6 m, facing the sensor 1 m in front of it, in a unit of `scale` metres.
PointCloud square(float scale) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 100; ++k) {
      points.emplace_back(scale * (0.006f * static_cast<float>(i) - 0.3f),
                          scale * (0.006f * static_cast<float>(k) - 0.3f), scale);
    }
  }
  return cloud_of(std::move(points));
}

PointCloud wild_numbers() {
  Random random(5);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 3000; ++i) {
    const auto exponent = static_cast<float>(random.uniform() * 76.0 - 38.0);
    points.push_back(std::pow(10.0f, exponent) * random.unit_vector().cast<float>());
  }
  return cloud_of(std::move(points));
}

struct BadScene {
  std::string name;
  PointCloud cloud;
  std::string note;  ///< part of what the result says; empty for nothing to say
};

void PrintTo(const BadScene& scene, std::ostream* out) { *out << scene.name; }

std::vector<BadScene> bad_scenes() {
  const Eigen::Vector3f somewhere(0.1f, 0.2f, 1.0f);
  std::vector<Eigen::Vector3f> behind;
  for (const Eigen::Vector3f& p : square(1.0f).points) behind.push_back(-p);
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 5000; ++i)
    line.emplace_back(0.0f, 0.0f, 0.5f + 1e-4f * static_cast<float>(i));
  return {
      {"NoPoint", {}, "empty"},
      {"OnlyNan", cloud_of(std::vector<Eigen::Vector3f>(400, {kNan, kNan, kNan}), 20), "empty"},
      {"OnlyInfinity", cloud_of(std::vector<Eigen::Vector3f>(400, {0.0f, kInfinity, 1.0f})), ""},
      {"OnePoint", cloud_of({somewhere}), ""},
      {"TwoPoints", cloud_of({somewhere, -somewhere}), ""},
      {"OnePlace", cloud_of(std::vector<Eigen::Vector3f>(5000, somewhere)), ""},
      {"TheSensorItself", cloud_of(std::vector<Eigen::Vector3f>(5000, Eigen::Vector3f::Zero())),
       ""},
      {"ALineOfSight", cloud_of(line), ""},
      {"BehindTheSensor", cloud_of(behind), ""},
      {"BareSquare", square(1.0f), ""},
      {"Millimetres", square(1000.0f), "units"},
      {"Micrometres", square(1e6f), "units"},
      {"ModelsInMillimetres", square(0.001f), "units"},
      {"WildNumbers", wild_numbers(), ""},
  };
}

class BadScenes : public ::testing::TestWithParam<BadScene> {};

TEST_P(BadScenes, GiveAnEmptyResultSoon) {
  static const auto library = std::make_shared<const ModelLibrary>(
      std::vector<ModelSource>{{"box", testing::make_box({0.15, 0.11, 0.07})}});
  const std::clock_t begin = std::clock();
  const RecognitionResult result =
      Recognizer(library, {}).recognize(GetParam().cloud, Eigen::Vector3d::Zero(), 1);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 1.0);
  EXPECT_TRUE(result.detections.empty());
  EXPECT_THAT(result.note, HasSubstr(GetParam().note));
}

INSTANTIATE_TEST_SUITE_P(Table, BadScenes, ::testing::ValuesIn(bad_scenes()),
                         [](const auto& row) { return row.param.name; });

TEST(BadModels, WithoutASurfaceAreRefusedByName) {
  const auto refusal = [](const std::variant<TriangleMesh, PointCloud>& shape) {
    return message_of<InputError>([&] { ModelLibrary({{"thing", shape}}); });
  };
  const Eigen::Vector3d a(0.0, 0.0, 0.0), b(0.1, 0.0, 0.0), c(0.2, 0.0, 0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(TriangleMesh{}), HasSubstr("thing"));
  EXPECT_THAT(refusal(TriangleMesh{{a, b, c}, {}}), HasSubstr("thing"));
  EXPECT_THAT(refusal(TriangleMesh{{a, b, c}, {{0, 1, 2}}}), HasSubstr("thing"));
  EXPECT_THAT(refusal(TriangleMesh{{a, b, {nan, 0.0, 0.0}}, {{0, 1, 2}}}), HasSubstr("thing"));
  EXPECT_THAT(refusal(PointCloud{}), HasSubstr("thing"));
  EXPECT_THAT(refusal(cloud_of({{0.1f, 0.2f, 0.3f}})), HasSubstr("thing"));
  EXPECT_THAT(refusal(cloud_of(std::vector<Eigen::Vector3f>(50, {kNan, 0.0f, 0.0f}))),
              HasSubstr("thing"));
  EXPECT_THAT(refusal(cloud_of(std::vector<Eigen::Vector3f>(50, {0.1f, 0.2f, 0.3f}))),
              HasSubstr("thing"));
}

TEST(BadModels, FlatAndOpenMeshesAreUsedOrRefusedButNeverCrash) {
  TriangleMesh open = testing::make_box({0.15, 0.11, 0.07});
  open.triangles.resize(open.triangles.size() - 2);
  const TriangleMesh flat{{{0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}, {0.2, 0.1, 0.0}, {0.0, 0.1, 0.0}},
                          {{0, 1, 2}, {0, 2, 3}}};
  for (const TriangleMesh& mesh : {open, flat}) {
    const auto library =
        std::make_shared<const ModelLibrary>(std::vector<ModelSource>{{"m", mesh}});
    const RecognitionResult result =
        Recognizer(library, {}).recognize(square(1.0f), Eigen::Vector3d::Zero(), 1);
    EXPECT_TRUE(result.detections.empty());  // the square is larger than either
  }
}

TEST(BadImages, WhoseSizeOrCalibrationIsWrongAreRefused) {
  const auto library = std::make_shared<const ModelLibrary>(
      std::vector<ModelSource>{{"box", testing::make_box({0.15, 0.11, 0.07})}});
  const Recognizer recognizer(library, {});
  RangeImage image;
  image.intrinsics = {40, 30, 50.0, 50.0, 19.5, 14.5};
  image.depth.assign(1200, 1.0f);
  EXPECT_NO_THROW(static_cast<void>(recognizer.recognize(image, 1)));
  const auto refused = [&](auto change) {
    RangeImage broken = image;
    change(broken);
    EXPECT_THROW(static_cast<void>(recognizer.recognize(broken, 1)), InputError);
  };
  refused([](RangeImage& i) { i.depth.pop_back(); });
  refused([](RangeImage& i) { i.intrinsics.width = -40; });
  refused([](RangeImage& i) { i.intrinsics.fx = 0.0; });
  refused([](RangeImage& i) { i.intrinsics.fy = std::numeric_limits<double>::quiet_NaN(); });
}

}  // namespace
}  // namespace binpick
