// Finds known objects in a scan, with nothing but the installed library:
//   recognize_cloud SCENE MODEL...
#include <cstdio>
#include <memory>

#include "models/cloud_file.h"
#include "models/errors.h"
#include "models/model_file.h"
#include "recognition/recognizer.h"

int main(int argc, char** argv) try {
  if (argc < 3) throw binpick::InputError("usage: recognize_cloud SCENE MODEL...");

  // What to look for: meshes (OBJ, STL, PLY, VTK) or scanned clouds (PLY, PCD, VTK), in metres.
  std::vector<binpick::ModelSource> sources;
  for (int i = 2; i < argc; ++i) {
    sources.push_back({.name = argv[i], .shape = binpick::read_model_file(argv[i])});
  }
  // Prepared once, for any number of scenes.
  const auto library = std::make_shared<const binpick::ModelLibrary>(sources);
  const binpick::Recognizer recognizer(library, {.jobs = 2});

  // Where to look: a cloud, and where the sensor stood in the cloud's own frame (here its origin).
  // A depth camera's picture goes in as it is, as a binpick::RangeImage.
  const binpick::PointCloud scene = binpick::read_cloud(argv[1]);
  const binpick::RecognitionResult result =
      recognizer.recognize(scene, Eigen::Vector3d::Zero(), /*seed=*/1);

  // What was found, best first. A note says why nothing can be found, a wrong unit for instance.
  if (!result.note.empty()) std::fprintf(stderr, "%s\n", result.note.c_str());
  for (const binpick::Detection& found : result.detections) {
    const Eigen::Vector3d p = 1e3 * found.T_scene_model.translation();
    std::printf("%s at %.0f %.0f %.0f mm, confidence %.2f\n", found.model.c_str(), p.x(), p.y(),
                p.z(), found.confidence);
  }
} catch (const std::exception& error) {  // InputError and IoError say which file, where and why
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
