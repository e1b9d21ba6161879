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

}  // namespace binpick
