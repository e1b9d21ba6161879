#include "experiments/doctor_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "experiments/content_hash.h"
#include "experiments/exit_codes.h"
#include "experiments/run_manifest.h"
#include "experiments/worker_process.h"
#include "models/object_model.h"
#include "scenes/scene.h"
#include "sim/physics_draw.h"
#include "sim/renderer.h"
#include "sim/world.h"

namespace binpick {
namespace {

constexpr int kSteps = 500;

/// Returns what was found; throws when the machine lacks it.
using Check = std::function<std::string()>;

std::shared_ptr<const WorldTemplate> test_cell() {
  const auto scene = models_directory().parent_path() / "scenes" / "single_bottle.yaml";
  return make_world_template(load_scene(scene));
}

std::string check_physics() {
  const auto cell = test_cell();
  const auto run = [&] {
    World world(cell, centre_physics(cell->parts.objects));
    for (int i = 0; i < kSteps; ++i) world.step();
    return world.save_state().numbers;
  };
  const std::vector<double> first = run();
  const std::vector<double> second = run();
  const std::size_t bytes = first.size() * sizeof(double);
  if (first.size() != second.size() || std::memcmp(first.data(), second.data(), bytes) != 0) {
    throw std::runtime_error("two runs of the same world end in different states");
  }
  ContentHash hash;
  hash.add({reinterpret_cast<const char*>(first.data()), bytes});
  return fmt::format("{} steps twice, same state {}", kSteps, hash.hex());
}

std::string check_rendering() {
  const auto cell = test_cell();
  World world(cell, centre_physics(cell->parts.objects));
  Renderer renderer(cell, 640, 480);
  const DepthImage first = renderer.depth(world, View::kDepthCamera, 640, 480);
  const DepthImage second = renderer.depth(world, View::kDepthCamera, 640, 480);
  const auto seen = std::count_if(first.z.begin(), first.z.end(), [](float z) { return z > 0.0f; });
  if (seen == 0) throw std::runtime_error("the depth image is empty");
  const std::size_t bytes = first.z.size() * sizeof(float);
  if (std::memcmp(first.z.data(), second.z.data(), bytes) != 0) {
    throw std::runtime_error("two images of the same world differ");
  }
  ContentHash hash;
  hash.add({reinterpret_cast<const char*>(first.z.data()), bytes});
  return fmt::format("OSMesa, depth image twice, same bytes {}", hash.hex());
}

std::string check_workers() {
  WorkerProcess worker;
  // An unusable configuration must come back as an answer, not as a dead process.
  worker.send({WorkerOrder::Type::kSetup, "no: experiment", "/", "", 0, 0});
  std::optional<std::string> line;
  while (!line && worker.receive()) line = worker.next_reply();
  const auto reply = line ? decode_reply(*line) : std::nullopt;
  if (!reply || reply->type != WorkerReply::Type::kInputError) {
    throw std::runtime_error("a worker process does not answer: " + worker.wait().text);
  }
  return "a worker process starts and answers";
}

std::string check_writing() {
  const std::filesystem::path here = std::filesystem::current_path();
  if (::access(here.c_str(), W_OK) != 0) {
    throw std::runtime_error(fmt::format("{} cannot be written; give --out", here.string()));
  }
  const auto space = std::filesystem::space(here);
  return fmt::format("{}, {:.1f} GB free", here.string(),
                     static_cast<double>(space.available) * 1e-9);
}

std::string check_ffmpeg() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path program = std::filesystem::path(folder) / "ffmpeg";
    if (::access(program.c_str(), X_OK) == 0) return program.string();
  }
  throw std::runtime_error("not found: no videos (apt install ffmpeg)");
}

bool passes(const char* name, const Check& check, bool needed) {
  try {
    fmt::print("ok       {}: {}\n", name, check());
    return true;
  } catch (const std::exception& error) {
    fmt::print("{}  {}: {}\n", needed ? "MISSING" : "without", name, error.what());
    return !needed;
  }
}

}  // namespace

void add_doctor_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("doctor", "Check what runs need from this machine");
  command->callback([&exit_code] {
    fmt::print("binpick {}, build {}\n", program_version(), program_build());
    bool well = passes("processor", cpu_class, true);
    well &= passes("physics", check_physics, true);
    well &= passes("rendering", check_rendering, true);
    well &= passes("workers", check_workers, true);
    well &= passes("writing here", check_writing, true);
    well &= passes("ffmpeg", check_ffmpeg, false);
    exit_code = well ? kExitOk : kExitGateFailed;
  });
}

}  // namespace binpick
