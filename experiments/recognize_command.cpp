#include "experiments/recognize_command.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <variant>

#include "experiments/detection_picture.h"
#include "experiments/exit_codes.h"
#include "models/errors.h"
#include "models/model_file.h"
#include "recognition/recognizer.h"
#include "sim/png_writer.h"

namespace binpick {
namespace {

struct FileWithUnit {
  std::string path;
  double unit = 1.0;  // metres
};

FileWithUnit split_unit(const std::string& argument) {
  const std::size_t colon = argument.rfind(':');
  if (colon == std::string::npos || std::filesystem::exists(argument)) return {argument, 1.0};
  const std::string unit = argument.substr(colon + 1);
  if (unit == "m") return {argument.substr(0, colon), 1.0};
  if (unit == "mm") return {argument.substr(0, colon), 0.001};
  throw InputError(
      fmt::format("{}: '{}' is no unit; write FILE, FILE:m or FILE:mm", argument, unit));
}

Eigen::Vector3d parse_viewpoint(const std::string& text) {
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int i = 0; i < 3; ++i) {
    const auto [next, error] = std::from_chars(at, end, viewpoint[i]);
    const bool separated = i == 2 ? next == end : next != end && *next == ',';
    if (error != std::errc() || !separated || !std::isfinite(viewpoint[i])) {
      throw InputError(fmt::format("--viewpoint {}: expected three numbers x,y,z in metres", text));
    }
    at = next + 1;
  }
  return viewpoint;
}

/// A scene given as a mesh counts by its vertices.
PointCloud as_cloud(ModelGeometry geometry) {
  if (auto* cloud = std::get_if<PointCloud>(&geometry)) return std::move(*cloud);
  PointCloud cloud;
  for (const Eigen::Vector3d& vertex : std::get<TriangleMesh>(geometry).vertices) {
    cloud.points.push_back(vertex.cast<float>());
  }
  cloud.width = static_cast<int>(cloud.points.size());
  cloud.height = 1;
  return cloud;
}

template <class Matrix>
nlohmann::json rows_of(const Matrix& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    nlohmann::json numbers = nlohmann::json::array();
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      numbers.push_back(matrix(row, column));
    }
    rows.push_back(std::move(numbers));
  }
  return rows;
}

nlohmann::json to_json(const RecognitionResult& result) {
  nlohmann::json detections = nlohmann::json::array();
  for (const Detection& detection : result.detections) {
    detections.push_back({{"model", detection.model},
                          {"T_scene_model", rows_of(detection.T_scene_model.matrix())},
                          {"visibility", detection.visibility},
                          {"penalty", detection.penalty},
                          {"explained_points", detection.explained_points},
                          {"confidence", detection.confidence},
                          {"covariance", rows_of(detection.covariance)}});
  }
  nlohmann::json timings = {{"total", result.total_seconds}};
  for (const StageTiming& timing : result.timings) timings[timing.stage] = timing.seconds;
  return {{"detections", std::move(detections)}, {"timings_s", std::move(timings)}};
}

void print_table(const RecognitionResult& result) {
  fmt::print("{} found in {:.3f} s\n", result.detections.size(), result.total_seconds);
  for (const Detection& detection : result.detections) {
    fmt::print(
        "\n{}\n  confidence {:.3f}, visibility {:.2f}, penalty {:.2f}, {} points explained\n",
        detection.model, detection.confidence, detection.visibility, detection.penalty,
        detection.explained_points);
    const auto deviation = [&](int first) {
      return std::sqrt(detection.covariance.diagonal().segment<3>(first).maxCoeff());
    };
    // Zero stands for unknown.
    if (deviation(3) > 0.0) {
      fmt::print("  standard deviation at most {:.2f} mm and {:.2f} deg per axis\n",
                 1e3 * deviation(3), deviation(0) * 180.0 / std::numbers::pi);
    }
    for (int row = 0; row < 3; ++row) {
      const auto numbers = detection.T_scene_model.matrix().row(row);
      fmt::print("  {:9.5f} {:9.5f} {:9.5f} {:10.5f} m\n", numbers[0], numbers[1], numbers[2],
                 numbers[3]);
    }
  }
  fmt::print("\n{} pairs, {} hypotheses, {} accepted\n", result.counters.pairs,
             result.counters.hypotheses, result.counters.accepted);
  for (const StageTiming& timing : result.timings) {
    fmt::print("  {:<18} {:7.1f} ms\n", timing.stage, 1e3 * timing.seconds);
  }
}

}  // namespace

int recognize_command(const RecognizeArguments& arguments) {
  RecognizerOptions options;
  options.setting =
      arguments.setting == "paper" ? RecognizerSetting::kPaper : RecognizerSetting::kDefault;
  options.jobs = arguments.jobs;
  options.validate();
  const Eigen::Vector3d viewpoint = parse_viewpoint(arguments.viewpoint);
  std::vector<ModelSource> sources;
  for (const std::string& argument : arguments.models) {
    const FileWithUnit file = split_unit(argument);
    sources.push_back({file.path, read_model_file(file.path, file.unit)});
  }
  const FileWithUnit file = split_unit(arguments.scene);
  const PointCloud scene = as_cloud(read_model_file(file.path, file.unit));
  const auto library = std::make_shared<const ModelLibrary>(sources, options.setting, options.jobs);
  const Recognizer recognizer(library, options);

  const RecognitionResult result = recognizer.recognize(scene, viewpoint, arguments.seed);
  if (!arguments.picture.empty()) {
    const ColourImage picture = detection_picture(scene, viewpoint, result.detections, *library);
    if (picture.rgb.empty()) {
      fmt::print(stderr, "{}: no points, so {} is not drawn\n", file.path, arguments.picture);
    } else {
      write_png(arguments.picture, picture);
    }
  }
  if (!result.note.empty()) fmt::print(stderr, "{}: {}\n", file.path, result.note);
  if (arguments.json) {
    fmt::print("{}\n", to_json(result).dump());
  } else {
    print_table(result);
  }
  return kExitOk;
}

void add_recognize_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RecognizeArguments>();
  CLI::App* command = app.add_subcommand("recognize", "Find known objects in a scan");
  command->footer(
      "Nothing has to be tuned. Poses are of the model's frame in the scan's frame, in metres.\n"
      "The table says how sure each detection is; --json adds the 6 x 6 covariance (rotation\n"
      "vector in rad, then position in m). docs/recognition_library.md describes every field.\n\n"
      "  binpick recognize --model box.obj:mm --model mug.ply --scene scan.pcd --picture out.png");
  command
      ->add_option("--model", arguments->models,
                   "Object to look for, as FILE[:unit] with unit m (default) or mm: a mesh (OBJ, "
                   "STL, PLY, VTK) or a scanned cloud (PLY, PCD, VTK); repeat for more")
      ->required();
  command
      ->add_option("--scene", arguments->scene,
                   "Scan to search, as FILE[:unit]: PLY, PCD or VTK, organised or not")
      ->required();
  command->add_option("--seed", arguments->seed, "Seed of all random draws")->capture_default_str();
  command->add_option("--jobs", arguments->jobs, "Threads; the result does not depend on it")
      ->capture_default_str()
      ->check(CLI::Range(1, 1024));
  command
      ->add_option("--setting", arguments->setting,
                   "paper: Algorithm 1 as printed; default: faster and more precise")
      ->capture_default_str()
      ->check(CLI::IsMember({"paper", "default"}));
  command
      ->add_option("--viewpoint", arguments->viewpoint,
                   "Position x,y,z of the sensor in the scene's frame, m")
      ->capture_default_str();
  command->add_option("--picture", arguments->picture,
                      "Write the scan with the detections' outlines to this PNG file");
  command->add_flag("--json", arguments->json, "Print the result as JSON on standard output");
  command->callback([arguments, &exit_code] { exit_code = recognize_command(*arguments); });
}

}  // namespace binpick
