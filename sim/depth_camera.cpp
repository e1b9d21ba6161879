#include "sim/depth_camera.h"

namespace binpick {

DepthCamera::DepthCamera(std::shared_ptr<const WorldTemplate> shared)
    : shared_(std::move(shared)),
      renderer_(shared_, shared_->parts.scene.camera.width, shared_->parts.scene.camera.height) {}

RangeImage DepthCamera::ideal(World& world) {
  const SceneCamera& camera = shared_->parts.scene.camera;
  RangeImage image;
  image.intrinsics = camera.intrinsics();
  image.T_world_camera = camera.T_world_camera();
  image.depth = renderer_.depth(world, View::kDepthCamera, camera.width, camera.height).z;
  return image;
}

RangeImage DepthCamera::capture(World& world, const StructuredLightOptions& noise, Seed seed) {
  RangeImage image = ideal(world);
  apply_structured_light(image, noise, seed);
  return image;
}

}  // namespace binpick
