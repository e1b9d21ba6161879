#include <fmt/format.h>

#include "models/errors.h"
#include "models/yaml_config.h"
#include "scenes/scene.h"

namespace binpick {
namespace {

constexpr int kDeepestExtension = 8;

// A file is read over the values of the one it extends. Its own `extends` must be known before, so
// every file is read twice; a file that nothing extends is the only one that must be complete.
Scene read_over_base(const std::filesystem::path& file, int depth, bool complete) {
  if (depth > kDeepestExtension) {
    throw InputError(fmt::format("{}: 'extends' leads through more than {} files; break the circle",
                                 file.string(), kDeepestExtension));
  }
  Scene scene;
  read_yaml(file, [&](ConfigVisitor& visitor) { scene.visit(visitor); });
  if (!scene.extends.empty()) {
    scene = read_over_base(file.parent_path() / scene.extends, depth + 1, false);
  }
  read_yaml(file, [&](ConfigVisitor& visitor) {
    scene.visit(visitor);
    if (!complete) return;
    for (const SceneProblem& problem : scene.validate()) {
      visitor.problem(problem.key, problem.message);
    }
  });
  scene.name = file.stem().string();
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& file) { return read_over_base(file, 0, true); }

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> files{file};
  (void)load_scene(file);  // refuses what cannot be used, endless extension among it
  while (true) {
    Scene scene;
    read_yaml(files.back(), [&](ConfigVisitor& visitor) { scene.visit(visitor); });
    if (scene.extends.empty()) return files;
    files.push_back(files.back().parent_path() / scene.extends);
  }
}

}  // namespace binpick
