// The recognizer beside its peers: writes generated scenes for them, answers the same scenes, and
// scores all answers alike. Driven by scripts/bench_peers.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "exchange.h"
#include "models/cloud_file.h"
#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "models/mesh_import.h"
#include "recognition/pose_metrics.h"
#include "recognition/recognition_score.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick::testing {
namespace {

struct Arguments {
  std::string folder;
  std::string models = "known";
  std::string variant = "kinect";
  int scenes = 5;
  Seed seed = 1000;
  std::string row;
  bool cut = false;
  std::vector<std::string> folders;
  std::vector<std::string> rows;
};

peers::Pose to_pose(const Eigen::Isometry3d& T) {
  peers::Pose pose{};
  for (int i = 0; i < 12; ++i) pose[static_cast<std::size_t>(i)] = T.matrix()(i / 4, i % 4);
  return pose;
}

Eigen::Isometry3d to_isometry(const peers::Pose& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = pose[static_cast<std::size_t>(i)];
  return T;
}

void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::ofstream out(file);
  out.precision(9);
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
      << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& p : mesh.vertices) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  if (!out) throw IoError(file.string() + ": cannot be written");
}

void write_models(const std::filesystem::path& folder, const std::vector<ModelSource>& sources) {
  constexpr double kSpacing = 0.002;  // m, of the oriented points
  std::ofstream list(folder / "models.txt");
  for (const ModelSource& source : sources) {
    const auto& mesh = std::get<TriangleMesh>(source.shape);
    list << source.name << ' ' << make_recognition_model(source.name, mesh, {}).diameter << '\n';
    write_mesh(folder / (source.name + ".ply"), mesh);
    const auto count = static_cast<std::size_t>(area(mesh) / (kSpacing * kSpacing));
    const PointCloud cloud = sample_surface(mesh, count, 1);
    std::ofstream points(folder / (source.name + ".txt"));
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      points << cloud.points[i].transpose() << ' ' << cloud.normals[i].transpose() << '\n';
    }
  }
}

/// In the camera's frame; laser scans without the points that were not measured.
peers::Scan to_scan(const RangeImage& image, bool organised) {
  peers::Scan scan;
  for (int v = 0; v < image.intrinsics.height; ++v) {
    for (int u = 0; u < image.intrinsics.width; ++u) {
      const Eigen::Vector3f p = image.p_camera(u, v).cast<float>();
      constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
      if (p.z() > 0.0f) {
        scan.points.push_back({p.x(), p.y(), p.z()});
      } else if (organised) {
        scan.points.push_back({kNan, kNan, kNan});
      }
    }
  }
  scan.width = organised ? image.intrinsics.width : static_cast<int>(scan.points.size());
  scan.height = organised ? image.intrinsics.height : 1;
  return scan;
}

void export_scenes(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.folder);
  const SceneGenerator generator(object_set(arguments.models).objects);
  write_models(arguments.folder, generator.known());
  for (int scene = 0; scene < arguments.scenes; ++scene) {
    const Seed seed = frame_seed(arguments.seed, arguments.variant, static_cast<Seed>(scene));
    SceneParameters parameters = draw_parameters(arguments.variant, seed);
    const bool organised = parameters.form != ScanForm::kUnorganisedCloud;
    const SyntheticFrame frame = generator.frame(parameters, seed);
    peers::write_scan(peers::scene_file(arguments.folder, scene, ".pcd"),
                      to_scan(frame.image, organised));
    parameters.surroundings = Surroundings::kTableCutAway;
    peers::write_scan(peers::scene_file(arguments.folder, scene, "_cut.pcd"),
                      to_scan(generator.frame(parameters, seed).image, organised));
    std::ofstream truth(peers::scene_file(arguments.folder, scene, "_truth.txt"));
    truth.precision(12);
    for (const TrueInstance& instance : frame.scene.instances) {
      truth << generator.known()[instance.model].name << ' ' << instance.visible_share << ' '
            << instance.in_frame;
      for (const double value : to_pose(instance.T_camera_model)) truth << ' ' << value;
      truth << '\n';
    }
  }
}

/// Ours, with nothing but models, scan and seed, one thread.
void answer(const Arguments& arguments) {
  std::vector<ModelSource> sources = object_set(arguments.models).models;
  for (ModelSource& source : sources) {
    source.shape = import_mesh(std::filesystem::path(arguments.folder) / (source.name + ".ply"));
  }
  const Recognizer recognizer(std::make_shared<const ModelLibrary>(sources), RecognizerOptions{});
  const auto recognize_scan = [&](const peers::Scan& scan, int scene) {
    PointCloud cloud;
    for (const auto& p : scan.points) cloud.points.emplace_back(p[0], p[1], p[2]);
    cloud.width = scan.width;
    cloud.height = scan.height;
    const peers::Clock clock;
    const RecognitionResult result =
        recognizer.recognize(cloud, Eigen::Vector3d::Zero(), static_cast<Seed>(scene));
    peers::Answer given;
    given.seconds = clock.seconds();
    for (const Detection& detection : result.detections) {
      given.objects.push_back({detection.model, 1.0, true, to_pose(detection.T_scene_model)});
    }
    return given;
  };
  peers::answer_scenes(arguments.folder, arguments.row, arguments.cut, 60, recognize_scan);
}

struct RowTotal {
  int found = 0, visible = 0, false_positives = 0, scenes = 0, failed = 0;
  int worse_than_ours = 0;
  std::vector<double> seconds;
  long peak_kilobytes = 0;
};

/// Found among the visible (at least 30 %, all in the image) and false ones of one answer.
struct Score {
  int found = 0, visible = 0, false_positives = 0;
};

Score score_answer(const peers::Answer& given, const std::vector<peers::Object>& truth,
                   const ModelLibrary& library) {
  SyntheticFrame frame;
  for (const peers::Object& object : truth) {
    std::size_t model = 0;
    while (library.models()[model].name != object.model) ++model;
    frame.scene.instances.push_back(
        {model, to_isometry(object.T_camera_model), object.visible_share, object.in_frame});
  }
  std::vector<Detection> detections;
  for (const peers::Object& object : given.objects) {
    Detection detection;
    detection.model = object.model;
    detection.T_scene_model = to_isometry(object.T_camera_model);
    detections.push_back(detection);
  }
  Tally tally;
  tally.add(score_frame(detections, frame, library.models()), frame);
  return {tally.found, tally.visible, tally.false_positives};
}

/// The first row is ours: the others are compared with it.
int score(const Arguments& arguments) {
  std::vector<RowTotal> totals(arguments.rows.size());
  fmt::print("{:<24} {:>7} {:<12} {:>9} {:>6} {:>9} {:>8}\n", "scene", "objects", "recognizer",
             "found", "false", "time s", "MB");
  for (const std::string& name : arguments.folders) {
    const std::filesystem::path folder(name);
    const ModelLibrary library(
        object_set(folder.filename().string().substr(0, folder.filename().string().find('_')))
            .models);
    for (int scene = 0; std::ifstream(peers::scene_file(name, scene, ".pcd")); ++scene) {
      const std::vector<peers::Object> truth = peers::read_truth(name, scene);
      Score ours;
      for (std::size_t r = 0; r < arguments.rows.size(); ++r) {
        const peers::Answer given =
            peers::read_answer(peers::scene_file(name, scene, "_" + arguments.rows[r] + ".txt"));
        const Score points = score_answer(given, truth, library);
        if (r == 0) ours = points;
        RowTotal& total = totals[r];
        ++total.scenes;
        total.found += points.found;
        total.visible += points.visible;
        total.false_positives += points.false_positives;
        total.seconds.push_back(given.seconds);
        total.peak_kilobytes = std::max(total.peak_kilobytes, given.peak_kilobytes);
        if (given.status != "ok") ++total.failed;
        const bool beats =
            points.found > ours.found ||
            (points.found == ours.found && points.false_positives < ours.false_positives);
        if (beats) ++total.worse_than_ours;
        fmt::print("{:<24} {:>7} {:<12} {:>4}/{:<4} {:>6} {:>9.3f} {:>8.0f} {}{}\n",
                   folder.filename().string() + " " + std::to_string(scene), truth.size(),
                   arguments.rows[r], points.found, points.visible, points.false_positives,
                   given.seconds, static_cast<double>(given.peak_kilobytes) / 1024.0,
                   given.status == "ok" ? "" : given.status, beats ? " better than ours" : "");
      }
    }
  }
  fmt::print("\n{:<12} {:>11} {:>7} {:>6} {:>12} {:>10} {:>8} {:>7} {:>16}\n", "total", "found",
             "recall", "false", "median s", "x ours", "peak MB", "failed", "beats ours on");
  for (std::size_t r = 0; r < arguments.rows.size(); ++r) {
    const RowTotal& total = totals[r];
    const double seconds = quantile(total.seconds, 0.5);
    fmt::print("{:<12} {:>5}/{:<5} {:>7.3f} {:>6} {:>12.3f} {:>10.1f} {:>8.0f} {:>7} {:>16}\n",
               arguments.rows[r], total.found, total.visible,
               static_cast<double>(total.found) / std::max(total.visible, 1), total.false_positives,
               seconds, seconds / quantile(totals[0].seconds, 0.5),
               static_cast<double>(total.peak_kilobytes) / 1024.0, total.failed,
               total.worse_than_ours);
  }
  const bool never_worse = std::all_of(totals.begin(), totals.end(),
                                       [](const RowTotal& t) { return t.worse_than_ours == 0; });
  return never_worse ? 0 : 1;
}

int exchange(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Generated scenes for other recognizers, our answers, and scores for all");
  app.require_subcommand(1);
  CLI::App* write = app.add_subcommand("export", "write scenes, models and truth");
  write->add_option("folder", arguments.folder)->required();
  write->add_option("--models", arguments.models, "known, toys or open");
  write->add_option("--variant", arguments.variant);
  write->add_option("--scenes", arguments.scenes);
  write->add_option("--seed", arguments.seed, "master seed");
  CLI::App* ours = app.add_subcommand("answer", "recognize in exported scenes");
  ours->add_option("folder", arguments.folder)->required();
  ours->add_option("row", arguments.row)->required();
  ours->add_option("--models", arguments.models, "whose symmetries are known");
  ours->add_flag("--cut", arguments.cut, "in the scans without the table");
  CLI::App* compare = app.add_subcommand("score", "score all answers; 1 if a peer beats ours");
  compare->add_option("--folder", arguments.folders, "named MODELS_...")->required();
  compare->add_option("--row", arguments.rows, "ours first")->required();
  CLI11_PARSE(app, argc, argv);
  if (write->parsed()) export_scenes(arguments);
  if (ours->parsed()) answer(arguments);
  return compare->parsed() ? score(arguments) : 0;
}

}  // namespace
}  // namespace binpick::testing

int main(int argc, char** argv) {
  try {
    return binpick::testing::exchange(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
