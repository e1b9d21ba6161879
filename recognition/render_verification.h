#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "recognition/depth_rasterizer.h"
#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// How a rendered model agrees with the range image, in pixels of the working resolution.
///
/// A pixel in which nothing was measured, one that a far occluder hides, and one on a support plane
/// say nothing about the hypothesis. What contradicts it:
struct RenderComparison {
  int rendered = 0;        ///< pixels that the model covers
  int matched = 0;         ///< depth and normal agree
  int bad_normal = 0;      ///< depth agrees, normal does not
  int violating = 0;       ///< the scene is behind the model: one would see through it
  int ragged = 0;          ///< the same within two pixels of the model's silhouette
  int near_occluded = 0;   ///< the scene is in front, but so little that it is rather the surface
                           ///< of something larger than an occluder
  double continued = 0.0;  ///< share of the silhouette beyond which the scene goes on in the
                           ///< model's tangent plane
  double expected = 0.0;   ///< matched pixels of a typical unoccluded view at this distance
  std::vector<int> explained;  ///< leaves of S* that matched pixels lie in, ascending

  /// Weighted share of contradicting pixels, 0 for a perfect match.
  [[nodiscard]] double badness() const;
  /// Matched pixels, less for contradictions: what a search over poses maximises.
  [[nodiscard]] double quality() const { return matched * (1.0 - 2.0 * badness()); }
  /// Share of the model's pixels that match.
  [[nodiscard]] double matched_share() const;
  /// Whether the hypothesis stands. Little evidence must be cleaner evidence.
  [[nodiscard]] bool accepts(double least_matched_share) const;
};

/// Renders the model at the pose and compares it with the scene, pixel by pixel. `epsilon` is the
/// band, along the model's normal, within which depths agree. O(triangles + covered pixels).
[[nodiscard]] RenderComparison compare_by_rendering(DepthRasterizer& rasterizer,
                                                    const ObservedScene& scene,
                                                    const RecognitionModel& model,
                                                    const Eigen::Isometry3f& T_camera_model,
                                                    float epsilon);

}  // namespace binpick
