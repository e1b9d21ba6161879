#include "experiments/recognize_command.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "experiments/exit_codes.h"
#include "models/errors.h"
#include "models/model_file.h"
#include "recognition/recognizer.h"

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

nlohmann::json to_json(const RecognitionResult& result) {
  nlohmann::json detections = nlohmann::json::array();
  for (const Detection& detection : result.detections) {
    nlohmann::json T = nlohmann::json::array();
    for (int row = 0; row < 4; ++row) {
      nlohmann::json numbers = nlohmann::json::array();
      for (int column = 0; column < 4; ++column) {
        numbers.push_back(detection.T_scene_model.matrix()(row, column));
      }
      T.push_back(std::move(numbers));
    }
    detections.push_back({{"model", detection.model},
                          {"T_scene_model", std::move(T)},
                          {"visibility", detection.visibility},
                          {"penalty", detection.penalty},
                          {"explained_points", detection.explained_points}});
  }
  nlohmann::json timings = {{"total", result.total_seconds}};
  for (const StageTiming& timing : result.timings) timings[timing.stage] = timing.seconds;
  return {{"detections", std::move(detections)}, {"timings_s", std::move(timings)}};
}

void print_table(const RecognitionResult& result) {
  fmt::print("{} found in {:.3f} s\n", result.detections.size(), result.total_seconds);
  for (const Detection& detection : result.detections) {
    fmt::print("\n{}\n  visibility {:.2f}, penalty {:.2f}, {} points explained\n", detection.model,
               detection.visibility, detection.penalty, detection.explained_points);
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
  auto library = std::make_shared<const ModelLibrary>(sources, options.setting);
  const Recognizer recognizer(std::move(library), options);

  const RecognitionResult result = recognizer.recognize(scene, viewpoint, arguments.seed);
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
  command
      ->add_option("--model", arguments->models,
                   "Object: OBJ, STL, PLY, PCD or VTK, as FILE[:unit] with unit m or mm; repeat")
      ->required();
  command->add_option("--scene", arguments->scene, "Scan, as FILE[:unit]")->required();
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
  command->add_flag("--json", arguments->json, "Print the result as JSON");
  command->callback([arguments, &exit_code] { exit_code = recognize_command(*arguments); });
}

}  // namespace binpick
