#pragma once

#include <memory>
#include <vector>

#include "control/perception.h"
#include "models/object_model.h"
#include "models/random.h"
#include "recognition/recognizer.h"

namespace binpick {

/// Gives the robot's brain eyes: the recognizer, fed with range images, its detections moved to the
/// world by the camera's calibration. Frame k draws from derive_seed(seed, k).
class RecognizerPerception final : public Perception {
 public:
  RecognizerPerception(std::shared_ptr<const Recognizer> recognizer, Seed seed);

  [[nodiscard]] std::vector<Detection> recognize(const RangeImage& image) override;

 private:
  std::shared_ptr<const Recognizer> recognizer_;
  Seed seed_;
  std::uint64_t frames_ = 0;
};

/// A recognizer for `objects`: their meshes and symmetries, each kind once.
[[nodiscard]] std::shared_ptr<const Recognizer> make_recognizer(
    const std::vector<ObjectModel>& objects, const RecognizerOptions& options);

}  // namespace binpick
