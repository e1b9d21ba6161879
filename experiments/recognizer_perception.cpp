#include "experiments/recognizer_perception.h"

namespace binpick {

RecognizerPerception::RecognizerPerception(std::shared_ptr<const Recognizer> recognizer, Seed seed)
    : recognizer_(std::move(recognizer)), seed_(seed) {}

std::vector<Detection> RecognizerPerception::recognize(const RangeImage& image) {
  RecognitionResult result = recognizer_->recognize(image, derive_seed(seed_, frames_++));
  for (Detection& detection : result.detections) {
    detection.T_scene_model = image.T_world_camera * detection.T_scene_model;
  }
  return std::move(result.detections);
}

std::shared_ptr<const Recognizer> make_recognizer(const std::vector<ObjectModel>& objects,
                                                  const RecognizerOptions& options) {
  std::vector<ModelSource> sources;
  for (const ObjectModel& object : objects) {
    sources.push_back({object.name, object.mesh, object.symmetries});
  }
  auto library = std::make_shared<const ModelLibrary>(sources, options.setting, options.jobs);
  return std::make_shared<const Recognizer>(std::move(library), options);
}

}  // namespace binpick
