#pragma once

#include <vector>

#include "models/detection.h"
#include "models/range_image.h"

namespace binpick {

/// Whatever finds objects in a range image. Control knows recognition by this alone.
class Perception {
 public:
  virtual ~Perception() = default;
  /// Detections with poses in the world frame (the image carries T_world_camera).
  [[nodiscard]] virtual std::vector<Detection> recognize(const RangeImage& image) = 0;
};

/// Two looks at the same scene as one: what both found with the more confident pose, and what
/// either found alone. Two detections of a model less than `same_place` (m) apart are one object.
[[nodiscard]] std::vector<Detection> merge_looks(std::vector<Detection> first,
                                                 const std::vector<Detection>& second,
                                                 double same_place = 0.03);

}  // namespace binpick
