#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "recognition/coverage_mask.h"
#include "recognition/depth_rasterizer.h"
#include "recognition/observed_scene.h"
#include "recognition/pixel_verdicts.h"
#include "recognition/recognition_model.h"
#include "recognition/sensor_estimate.h"

namespace binpick {

/// What the range image says about a hypothesis: the rendered model against the scene, in pixels of
/// the working resolution. Every rendered pixel is counted once; what was not measured, lies on a
/// support plane or is hidden by something far in front says nothing for or against.
struct HypothesisEvidence {
  int rendered = 0;    ///< pixels that the model covers
  int matched = 0;     ///< depth and normal agree
  int bad_normal = 0;  ///< depth agrees, normal does not
  int seen_through =
      0;  ///< the scene is behind the model, three pixels or more from the silhouette
  int seen_through_rim = 0;  ///< the same within two pixels of the silhouette
  /// The scene is in front, but so little that it is rather the surface of something larger than an
  /// occluder: inside the silhouette, and where the scene is smooth. Beside a step of depth it is
  /// the sensor that lets a neighbour grow.
  int near_occluded = 0;
  int far_occluded = 0;  ///< an occluder, or a surface that a better hypothesis explains
  int missing = 0;       ///< nothing was measured
  int on_support = 0;    ///< depth agrees with a support plane
  int claimed = 0;       ///< depth agrees, but another object explains the pixel

  /// Samples of the model's silhouette, each walked outwards and, where the scene is behind the
  /// model there, inwards.
  int edges = 0;
  int edges_seen = 0;        ///< nothing stands in front of the model there
  int edges_matched = 0;     ///< the scene steps back near the silhouette
  int edges_missed = 0;      ///< the scene is behind the model well inside the silhouette
  int edges_continued = 0;   ///< the surface goes on beyond the silhouette
  int edges_open = 0;        ///< the surface ends at what was not measured
  float edge_offset = 0.0f;  ///< mean place of the step, pixels outwards: the sensor's dilation
  float edge_spread = 0.0f;  ///< standard deviation of the steps' places, pixels

  float residual_mean = 0.0f;  ///< of matched pixels, along the normal, in model tolerances
  float residual_rms = 0.0f;   ///< of matched pixels, in limits of agreement
  float normal_error = 0.0f;   ///< mean of 1 - cos of the angle between the normals
  float second_face = 0.0f;    ///< middle eigenvalue of the scatter of the matched normals, whose
                               ///< trace is 1: 0 for a single flat face
  /// Least eigenvalue of the information about the place that matched pixels give along their
  /// normals and the silhouette's steps across it, in matched pixels: whether it could slide.
  float least_information = 0.0f;
  float expected = 0.0f;  ///< matched pixels of a typical unoccluded view at this distance
};

/// Which accepted hypothesis explains a pixel of the working resolution; -1 for none.
using PixelClaims = std::vector<std::int32_t>;

/// A pixel in which model and scene agree.
struct MatchedPixel {
  Eigen::Vector3f p;  ///< of the model, camera frame
  Eigen::Vector3f normal;
  Eigen::Vector3f q;      ///< of the scene
  float variance = 0.0f;  ///< of q along the normal, from the sensor alone, m^2
};

/// A place at which the scene steps back beside the model's silhouette.
struct SilhouetteStep {
  int u = 0, v = 0;    ///< the silhouette's pixel in the working image
  int du = 0, dv = 0;  ///< the direction outwards that was walked
  int offset = 0;      ///< pixels from there to the last one on the surface
  float depth = 0.0f;  ///< of the model, m
  Eigen::Vector2f outwards = Eigen::Vector2f::Zero();  ///< silhouette's normal in the image
};

/// Pixels [u0, u1) x [v0, v1) of the working image, or of what would lie beside it.
struct PixelBox {
  int u0 = 0, v0 = 0, u1 = 0, v1 = 0;

  [[nodiscard]] bool overlaps(const PixelBox& other) const {
    return u0 < other.u1 && other.u0 < u1 && v0 < other.v1 && other.v0 < v1;
  }
};

/// How much work it is to gather evidence for a pose that left `evidence`, in pixels and triangles:
/// for parallel_for_longest_first.
[[nodiscard]] inline int evidence_cost(const RecognitionModel& model,
                                       const HypothesisEvidence& evidence) {
  return evidence.rendered + static_cast<int>(model.render_mesh.triangles.size());
}

/// Renders hypotheses and compares them with one scene. Keeps its buffers between calls: one object
/// per thread.
class EvidenceGatherer {
 public:
  EvidenceGatherer(const ObservedScene& scene, const SensorEstimate& sensor)
      : scene_(scene), sensor_(sensor) {}

  /// The evidence for a pose. Pixels that `claims` (when given) holds for somebody else than
  /// `claimant` are not the hypothesis' own. O(triangles + covered pixels), allocates nothing once
  /// warm.
  [[nodiscard]] HypothesisEvidence gather(const RecognitionModel& model,
                                          const Eigen::Isometry3f& T_camera_model,
                                          const PixelClaims* claims = nullptr,
                                          std::int32_t claimant = -1);

  /// The model at a pose as gather renders it; valid until the next call.
  const RenderedModel& render(const RecognitionModel& model,
                              const Eigen::Isometry3f& T_camera_model);
  /// As gather, of a pose as it was rendered before: about half the work. `rendered` must live
  /// until the next call.
  [[nodiscard]] HypothesisEvidence gather_again(const RecognitionModel& model,
                                                const Eigen::Isometry3f& T_camera_model,
                                                const RenderedModel& rendered,
                                                const PixelClaims* claims = nullptr,
                                                std::int32_t claimant = -1);

  /// The pixels that the last call of gather may have looked at, or that of render leads it to.
  [[nodiscard]] PixelBox reached() const;

  /// Replaces `pixels` by those whose depth the model explained in the last call of gather,
  /// ascending indices into the scene's working image.
  void explained_pixels(std::vector<int>& pixels) const;

  /// How many pixels matched in the last call of gather that `claims` leaves to `claimant`.
  [[nodiscard]] int matched_count(const PixelClaims& claims, std::int32_t claimant) const;

  /// Replaces `pixels` by those that matched in the last call of gather, every `stride`-th in both
  /// directions, and returns the model's points in them.
  void matched_pixels(int stride, std::vector<MatchedPixel>& pixels) const;

  /// The steps beside the silhouette in the last call of gather.
  [[nodiscard]] const std::vector<SilhouetteStep>& silhouette_steps() const { return steps_; }

 private:
  friend class EvidencePass;

  const ObservedScene& scene_;
  const SensorEstimate& sensor_;
  DepthRasterizer rasterizer_;
  const RenderedModel* rendered_ = nullptr;
  const RecognitionModel* model_ = nullptr;
  Eigen::Matrix3f R_camera_model_ = Eigen::Matrix3f::Identity();
  std::vector<float> ray_x_;       // x / z of the window's columns
  std::vector<Verdict> verdicts_;  // of the window's pixels
  CoverageMask covered_;           // by the model
  CoverageMask seen_through_;      // of the verdicts, for these two depend on the silhouette
  CoverageMask near_occluded_;
  std::vector<SilhouetteStep> steps_;
};

/// Models are wrong by about this much, diameters.
constexpr double kModelExactness = 0.01;

/// The band along the normal within which a model and a noise-free scene agree, m: models are not
/// exact, and sensors bend their depth slowly.
[[nodiscard]] inline float model_tolerance(const RecognitionModel& model) {
  return static_cast<float>(kModelExactness) * model.diameter;
}

}  // namespace binpick
