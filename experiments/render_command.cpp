#include "experiments/render_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "experiments/exit_codes.h"
#include "models/errors.h"
#include "scenes/scene.h"
#include "sim/depth_camera.h"
#include "sim/pile.h"
#include "sim/png_writer.h"
#include "sim/world.h"

namespace binpick {
namespace {

constexpr int kPictureWidth = 1280;
constexpr int kPictureHeight = 800;

struct RenderArguments {
  std::string scene;
  std::string out;
  Seed seed = 1;
  bool noise = true;
  std::vector<double> pose_deg;
};

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw IoError(fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  }
}

// Averaging blocks of 2 x 2 pixels smooths the edges, which llvmpipe's own sampling does poorly.
ColourImage half_size(const ColourImage& image) {
  ColourImage half{image.width / 2, image.height / 2, {}};
  half.rgb.reserve(image.rgb.size() / 4);
  const auto at = [&](int u, int v, int channel) {
    return unsigned{image.rgb[static_cast<std::size_t>(3 * (v * image.width + u) + channel)]};
  };
  for (int v = 0; v < half.height; ++v) {
    for (int u = 0; u < half.width; ++u) {
      for (int channel = 0; channel < 3; ++channel) {
        const unsigned sum = at(2 * u, 2 * v, channel) + at(2 * u + 1, 2 * v, channel) +
                             at(2 * u, 2 * v + 1, channel) + at(2 * u + 1, 2 * v + 1, channel);
        half.rgb.push_back(static_cast<std::uint8_t>((sum + 2) / 4));
      }
    }
  }
  return half;
}

ColourImage smooth_picture(Renderer& renderer, World& world, View view, int width, int height) {
  return half_size(renderer.colour(world, view, 2 * width, 2 * height));
}

int render(const RenderArguments& arguments) {
  const Scene scene = load_scene(arguments.scene);
  const auto shared = make_world_template(scene);
  World world(shared, draw_physics(shared->parts.objects, derive_seed(arguments.seed, "physics")));
  if (scene.arrangement == "pile") {
    const PileReport report = drop_pile(world, derive_seed(arguments.seed, "pile"));
    fmt::print(stderr, "pile of {} objects: {} after {} attempt(s)\n", world.object_count(),
               report.settled ? "settled" : "not settled", report.attempts);
  }
  if (!arguments.pose_deg.empty()) {
    world.set_arm_position(Eigen::Map<const JointVector>(arguments.pose_deg.data()) * kDegree,
                           world.sensors().gripper.width);
  }
  const std::filesystem::path out = arguments.out;
  make_folder(out);
  DepthCamera camera(shared);
  StructuredLightOptions noise;
  noise.enabled = arguments.noise;
  const RangeImage depth = camera.capture(world, noise, derive_seed(arguments.seed, "depth noise"));
  write_depth_png(out / "depth_mm.png", depth);
  write_png(out / "depth.png", false_colour(depth));
  Renderer& renderer = camera.renderer();
  const SceneCamera& sensor = scene.camera;
  write_png(out / "segmentation.png", false_colour(renderer.segmentation(
                                          world, View::kDepthCamera, sensor.width, sensor.height)));
  Renderer large(shared, 2 * std::max(kPictureWidth, sensor.width),
                 2 * std::max(kPictureHeight, sensor.height));
  write_png(out / "camera.png",
            smooth_picture(large, world, View::kDepthCamera, sensor.width, sensor.height));
  write_png(out / "colour.png",
            smooth_picture(large, world, View::kPicture, kPictureWidth, kPictureHeight));
  for (const char* name :
       {"colour.png", "camera.png", "depth.png", "depth_mm.png", "segmentation.png"}) {
    fmt::print("{}\n", (out / name).string());
  }
  return kExitOk;
}

}  // namespace

void add_render_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command =
      app.add_subcommand("render", "Render a scene: the cell, and what its depth camera sees");
  command->add_option("SCENE", arguments->scene, "scene file (YAML)")->required();
  command->add_option("--out", arguments->out, "folder for the pictures")->required();
  command->add_option("--seed", arguments->seed, "seed of pile, physics and noise")
      ->capture_default_str();
  command
      ->add_option("--noise", arguments->noise,
                   "on: depth as a structured-light sensor measures it; off: ideal depth")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, bool>{{"on", true}, {"off", false}}))
      ->default_str("on");
  command->add_option("--pose", arguments->pose_deg, "joint angles of the arm [the overview], deg")
      ->expected(kArmJoints);
  command->callback([arguments, &exit_code] { exit_code = render(*arguments); });
}

}  // namespace binpick
