#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "models/random.h"
#include "models/range_image.h"
#include "recognition/scene_octree.h"
#include "recognition/scene_pixel.h"
#include "recognition/sensor_estimate.h"
#include "recognition/support_plane.h"

namespace binpick {

/// The projection of a camera, or of its image with blocks of `block` x `block` pixels made one.
[[nodiscard]] Projection projection_of(const CameraIntrinsics& camera, int block = 1);

/// The distance between neighbouring points on a surface that faces the sensor at the median depth,
/// m; 0 when nothing was measured.
[[nodiscard]] double point_spacing(const RangeImage& image);

/// What the recognizer must know about models to look at a scene in the right scale.
struct SceneScale {
  double leaf_size = 0.0;  ///< finest leaf, m; the scene's resolution may ask for a coarser one
  double least_plane_area = 0.0;  ///< of a support plane, m^2
};

/// The scene S in camera coordinates, prepared for Algorithm 1: range image at working resolution,
/// octree and S*, support planes, normals and what they tell about the sensor. Threads share it
/// freely between calls of set_explained().
class ObservedScene {
 public:
  ObservedScene(const RangeImage& image, const SceneScale& scale, int jobs, Seed seed);

  [[nodiscard]] const Projection& projection() const noexcept { return projection_; }
  [[nodiscard]] const std::vector<ScenePixel>& pixels() const noexcept { return pixels_; }
  [[nodiscard]] const ScenePixel& pixel(int index) const {
    return pixels_[static_cast<std::size_t>(index)];
  }
  /// The pixels as hypotheses are searched in them: what is explained lies on a support plane.
  [[nodiscard]] const std::vector<ScenePixel>& searched_pixels() const noexcept {
    return searched_pixels_;
  }
  /// The leaf of the octree that a pixel's point lies in, or -1.
  [[nodiscard]] int leaf_of_pixel(int index) const {
    return leaf_of_pixel_[static_cast<std::size_t>(index)];
  }

  [[nodiscard]] const SceneOctree& octree() const noexcept { return octree_; }
  [[nodiscard]] const std::vector<SupportPlane>& support_planes() const noexcept { return planes_; }
  /// The leaves off the support planes: what is sampled.
  [[nodiscard]] const std::vector<int>& object_leaves() const noexcept { return object_leaves_; }
  [[nodiscard]] bool on_support(int leaf) const {
    return on_support_[static_cast<std::size_t>(leaf)] != 0;
  }
  /// The normal at a point of S*, towards the sensor.
  [[nodiscard]] const Eigen::Vector3f& normal(int leaf) const {
    return normals_[static_cast<std::size_t>(leaf)];
  }
  /// Whether the neighbourhood of the point is flat enough for its normal to mean something.
  [[nodiscard]] bool normal_is_reliable(int leaf) const {
    return reliable_[static_cast<std::size_t>(leaf)] != 0;
  }

  /// Whether a point pair may have the leaf: off the support planes and not explained.
  [[nodiscard]] bool is_open(int leaf) const {
    return is_open_[static_cast<std::size_t>(leaf)] != 0;
  }

  /// Takes what objects explain, in pixels of the working resolution, out of the search for more of
  /// them: like a support plane it hides and stops what lies behind, but has no point pairs and
  /// agrees with no model. Replaces what was explained before.
  void set_explained(const std::vector<int>& pixels);

  /// Noise of the depth along the surface normal, measured as the deviation of small patches from
  /// planes, m.
  [[nodiscard]] float noise() const noexcept { return noise_; }
  /// The noise of single pixels at the working resolution.
  [[nodiscard]] const SensorEstimate& sensor() const noexcept { return sensor_; }

  /// Wall times of the preparation, s.
  struct Timings {
    double image = 0.0, octree = 0.0, planes = 0.0, normals = 0.0;
  };
  [[nodiscard]] const Timings& timings() const noexcept { return timings_; }

 private:
  void mark_support(int jobs);
  void estimate_normals(int jobs);
  void fill_pixels(int jobs);
  [[nodiscard]] int pixel_of_leaf(int leaf) const;

  Projection projection_;
  Timings timings_;
  std::vector<ScenePixel> pixels_;
  std::vector<ScenePixel> searched_pixels_;
  std::vector<std::int32_t> leaf_of_pixel_;
  SceneOctree octree_;
  std::vector<SupportPlane> planes_;
  std::vector<int> object_leaves_;
  std::vector<std::int32_t> pixel_of_object_leaf_;
  std::vector<std::uint8_t> on_support_;
  std::vector<int> explained_;  // pixels
  std::vector<std::uint8_t> is_open_;
  std::vector<std::uint8_t> reliable_;
  std::vector<Eigen::Vector3f> normals_;
  float noise_ = 0.0f;
  SensorEstimate sensor_;
};

}  // namespace binpick
