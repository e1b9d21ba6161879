#pragma once

#include <memory>

#include "models/random.h"
#include "models/range_image.h"
#include "sim/renderer.h"
#include "sim/structured_light.h"
#include "sim/world.h"

namespace binpick {

/// The scene's depth camera: renders metric depth and, if asked, spoils it as a structured-light
/// sensor does. Holds a GL context: use it on the thread that made it; it serves all worlds of its
/// template, one after the other.
class DepthCamera {
 public:
  explicit DepthCamera(std::shared_ptr<const WorldTemplate> shared);

  /// The ideal range image; 0 beyond the far plane.
  [[nodiscard]] RangeImage ideal(World& world);
  /// As the sensor sees it; `seed` belongs to this one frame.
  [[nodiscard]] RangeImage capture(World& world, const StructuredLightOptions& noise, Seed seed);
  [[nodiscard]] Renderer& renderer() noexcept { return renderer_; }

 private:
  std::shared_ptr<const WorldTemplate> shared_;
  Renderer renderer_;
};

}  // namespace binpick
