#include "experiments/recognize_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "experiments/exit_codes.h"
#include "experiments/program.h"
#include "models/cloud_file.h"
#include "models/mesh_geometry.h"
#include "models/mesh_import.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

struct Output {
  int exit_code = 0;
  std::string out;
  std::string error;
};

Output recognize(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"binpick", "recognize"});
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Output output;
  output.exit_code = program_main(static_cast<int>(words.size()), words.data(), TrialKindRegistry(),
                                  {add_recognize_command});
  output.out = ::testing::internal::GetCapturedStdout();
  output.error = ::testing::internal::GetCapturedStderr();
  return output;
}

class RecognizeCommand : public ::testing::Test {
 protected:
  const std::string rusk_ = std::string(BINPICK_SOURCE_DIR) + "/models/objects/rusk/rusk.obj";
  TemporaryFolder folder_;
};

TEST_F(RecognizeCommand, MistakesGetOneLineAndExitCodeTwo) {
  const std::string empty = folder_.write("empty.ply", "").string();
  const std::string garbage = folder_.write("garbage.pcd", "VERSION .7\nFIELDS\xff\n").string();
  const std::string cut =
      folder_
          .write("cut.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 9 fl")
          .string();
  const std::string bad_mesh = folder_.write("mesh.obj", "f 1 2 3\n").string();
  const std::vector<std::vector<std::string>> mistakes{
      {"--model", rusk_, "--scene", empty},
      {"--model", rusk_, "--scene", garbage},
      {"--model", rusk_, "--scene", cut},
      {"--model", rusk_, "--scene", "/nowhere/scan.pcd"},
      {"--model", bad_mesh, "--scene", rusk_},
      {"--model", empty, "--scene", rusk_},
      {"--model", "/nowhere/model.obj", "--scene", rusk_},
      {"--model", rusk_ + ":inch", "--scene", rusk_},
      {"--model", rusk_, "--scene", rusk_, "--viewpoint", "1,2"},
      {"--model", rusk_, "--scene", rusk_, "--viewpoint", "1,2,nan"},
      {"--model", rusk_, "--model", rusk_, "--scene", rusk_},
  };
  for (const auto& arguments : mistakes) {
    const Output output = recognize(arguments);
    EXPECT_EQ(output.exit_code, kExitInput) << output.error;
    EXPECT_EQ(output.out, "");
    EXPECT_EQ(std::count(output.error.begin(), output.error.end(), '\n'), 1) << output.error;
  }
}

TEST_F(RecognizeCommand, APictureThatCannotBeWrittenIsAnIoError) {
  const Output output = recognize({"--model", rusk_, "--scene", rusk_, "--viewpoint", "0,0,1",
                                   "--picture", "/nowhere/picture.png"});
  EXPECT_EQ(output.exit_code, kExitIo);
  EXPECT_EQ(std::count(output.error.begin(), output.error.end(), '\n'), 1) << output.error;
}

/// A dense scan of a mesh, seen from the origin 0.7 m away.
PointCloud scan_of(const std::string& mesh) {
  Eigen::Isometry3d T_scan_object = Eigen::Isometry3d::Identity();
  T_scan_object.translate(Eigen::Vector3d(0.0, 0.0, 0.7));
  T_scan_object.rotate(Eigen::AngleAxisd(0.8, Eigen::Vector3d(1.0, 0.7, 0.3).normalized()));
  PointCloud scan;
  const PointCloud surface = sample_surface(import_mesh(mesh), 60000, 1);
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Eigen::Vector3d p = T_scan_object * surface.points[i].cast<double>();
    const Eigen::Vector3d n = T_scan_object.linear() * surface.normals[i].cast<double>();
    if (n.dot(p) < 0.0) scan.points.push_back(p.cast<float>());
  }
  scan.width = static_cast<int>(scan.points.size());
  scan.height = 1;
  return scan;
}

TEST_F(RecognizeCommand, AWrongUnitIsSaidAndIsNoError) {
  const std::string scene = folder_ / "scan.ply";
  write_ply(scene, scan_of(rusk_));
  const Output output = recognize({"--model", rusk_ + ":mm", "--scene", scene, "--json"});
  EXPECT_EQ(output.exit_code, kExitOk);
  EXPECT_THAT(output.error, HasSubstr("check the units"));
  EXPECT_TRUE(nlohmann::json::parse(output.out).at("detections").empty());
}

TEST_F(RecognizeCommand, JsonHoldsPoseConfidenceCovarianceAndTimes) {
  const std::string scene = folder_ / "scan.ply";
  const std::string picture = folder_ / "picture.png";
  write_ply(scene, scan_of(rusk_));
  const Output output =
      recognize({"--model", rusk_ + ":m", "--scene", scene, "--json", "--picture", picture});
  EXPECT_EQ(output.exit_code, kExitOk) << output.error;
  EXPECT_THAT(read_whole_file(picture), ::testing::StartsWith("\x89PNG"));

  const nlohmann::json result = nlohmann::json::parse(output.out);
  ASSERT_EQ(result.at("detections").size(), 1u);
  const nlohmann::json& found = result["detections"][0];
  EXPECT_EQ(found.at("model"), rusk_);
  EXPECT_NEAR(found.at("T_scene_model")[2][3].get<double>(), 0.7, 0.005);
  EXPECT_EQ(found["T_scene_model"][3], nlohmann::json({0.0, 0.0, 0.0, 1.0}));
  EXPECT_GE(found.at("confidence").get<double>(), 0.0);
  EXPECT_LE(found.at("confidence").get<double>(), 1.0);
  ASSERT_EQ(found.at("covariance").size(), 6u);
  EXPECT_EQ(found["covariance"][0].size(), 6u);
  EXPECT_EQ(found["covariance"][1][4], found["covariance"][4][1]);
  EXPECT_GT(found.at("visibility").get<double>(), 0.15);
  EXPECT_GT(result.at("timings_s").at("total").get<double>(), 0.0);
}

}  // namespace
}  // namespace binpick
