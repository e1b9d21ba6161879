#include "recognition/hypothesis_evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace binpick {
namespace {

constexpr float kSigmas = 3.0f;
constexpr float kNearOcclusionBands = 4.0f;  // limits: what is farther in front is an occluder
constexpr float kLikeNormal = 0.77f;         // 40 degrees
constexpr float kContinuedNormal = 0.94f;    // 20 degrees
constexpr int kRimWidth = 2;
constexpr int kInwardReach = 3;
constexpr int kLeastOutwardReach = 5;   // pixels: beyond any sensor's dilation
constexpr float kLeavesOutward = 1.6f;  // and this many leaves beyond the silhouette
constexpr float kSteepest = 5.0f;       // tangent of the slant at which a surface may go on
constexpr float kContinuedBand = 1.5f;  // limits
constexpr float kStepBand = 3.0f;       // limits

enum Verdict : std::uint8_t {
  kOutside,
  kMatched,
  kBadNormal,
  kSeenThrough,
  kNearOccluded,
  kFarOccluded,
  kMissing,
  kOnSupport,
  kClaimed
};

}  // namespace

/// One comparison: the model is rendered, the pixels are judged in one sweep, then the silhouette.
class EvidencePass {
 public:
  EvidencePass(EvidenceGatherer& gatherer, const RecognitionModel& model,
               const Eigen::Isometry3f& T_camera_model, const PixelClaims* claims,
               std::int32_t claimant)
      : gatherer_(gatherer),
        scene_(gatherer.scene_),
        projection_(gatherer.scene_.projection()),
        model_(model),
        R_(T_camera_model.linear()),
        tolerance_(model_tolerance(model)),
        pixel_width_(1.0f / projection_.fx),
        claims_(claims),
        claimant_(claimant),
        window_(gatherer.rasterizer_.render(model.render_mesh, T_camera_model, projection_)) {
    gatherer.rendered_ = &window_;
    gatherer.model_ = &model;
    gatherer.R_camera_model_ = R_;
    gatherer.steps_.clear();
  }

  HypothesisEvidence run() {
    judge_pixels();
    walk_silhouette();
    finish();
    return evidence_;
  }

 private:
  [[nodiscard]] int scene_index(int u, int v) const {
    return (window_.v0 + v) * projection_.width + window_.u0 + u;
  }
  [[nodiscard]] bool is_claimed(int index) const {
    if (claims_ == nullptr) return false;
    const std::int32_t owner = (*claims_)[static_cast<std::size_t>(index)];
    return owner >= 0 && owner != claimant_;
  }
  /// Square of the largest residual along the normal that counts as agreement.
  [[nodiscard]] float limit_squared(float z, float n_ray) const {
    return tolerance_ * tolerance_ +
           kSigmas * kSigmas * gatherer_.sensor_.normal_variance(z, n_ray, pixel_width_);
  }
  [[nodiscard]] Eigen::Vector3f normal_of(std::int32_t triangle) const {
    return R_ * model_.render_mesh.normals[static_cast<std::size_t>(triangle)];
  }

  void judge_pixels() {
    std::vector<float>& ray_x = gatherer_.ray_x_;
    ray_x.resize(static_cast<std::size_t>(window_.width));
    for (int u = 0; u < window_.width; ++u) {
      ray_x[static_cast<std::size_t>(u)] =
          (static_cast<float>(window_.u0 + u) - projection_.cx) / projection_.fx;
    }
    gatherer_.verdicts_.assign(window_.depth.size(), kOutside);
    std::size_t i = 0;
    for (int v = 0; v < window_.height; ++v) {
      const float ray_y = (static_cast<float>(window_.v0 + v) - projection_.cy) / projection_.fy;
      for (int u = 0; u < window_.width; ++u, ++i) {
        const std::int32_t triangle = window_.triangle[i];
        if (triangle < 0) continue;
        if (triangle != last_triangle_) change_triangle(triangle);
        const float n_ray =
            normal_.x() * ray_x[static_cast<std::size_t>(u)] + normal_.y() * ray_y + normal_.z();
        gatherer_.verdicts_[i] = judge(scene_index(u, v), window_.depth[i], n_ray);
      }
    }
    change_triangle(last_triangle_);
  }

  void change_triangle(std::int32_t triangle) {
    if (run_ > 0) scatter_.noalias() += static_cast<float>(run_) * normal_ * normal_.transpose();
    run_ = 0;
    if (triangle < 0) return;
    last_triangle_ = triangle;
    normal_ = normal_of(triangle);
  }

  Verdict judge(int index, float z, float n_ray) {
    const ScenePixel& pixel = scene_.pixel(index);
    if (!(pixel.depth > 0.0f)) return kMissing;
    const float in_front = n_ray * (pixel.depth - z);
    const float limit = limit_squared(z, n_ray);
    const float square = in_front * in_front;
    if (square > limit) {
      if (in_front < 0.0f) return kSeenThrough;
      const bool near = square < kNearOcclusionBands * kNearOcclusionBands * limit;
      return near && !is_claimed(index) ? kNearOccluded : kFarOccluded;
    }
    if (is_claimed(index)) return kClaimed;
    if ((pixel.flags & ScenePixel::kSupport) != 0) return kOnSupport;
    if ((pixel.flags & ScenePixel::kNormal) != 0) {
      const float cosine = normal_.dot(pixel.normal());
      if (cosine < kLikeNormal) return kBadNormal;
      normal_error_ += std::max(1.0f - cosine, 0.0f);  // stored normals are rounded
      ++normals_;
    }
    ++run_;
    residual_sum_ += in_front;
    residual_squares_ += square / limit;
    return kMatched;
  }

  [[nodiscard]] Verdict verdict_at(int u, int v) const {
    if (u < 0 || v < 0 || u >= window_.width || v >= window_.height) return kOutside;
    return static_cast<Verdict>(gatherer_.verdicts_[window_.index(u, v)]);
  }
  [[nodiscard]] bool near_silhouette(int u, int v) const {
    for (int step = 1; step <= kRimWidth; ++step) {
      if (verdict_at(u - step, v) == kOutside || verdict_at(u + step, v) == kOutside ||
          verdict_at(u, v - step) == kOutside || verdict_at(u, v + step) == kOutside) {
        return true;
      }
    }
    return false;
  }

  /// Counts the verdicts; every other pixel of the silhouette is walked.
  void walk_silhouette() {
    constexpr std::array<std::array<int, 2>, 4> kDirections = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    for (int v = 0; v < window_.height; ++v) {
      for (int u = 0; u < window_.width; ++u) {
        const Verdict verdict = verdict_at(u, v);
        if (verdict == kOutside) continue;
        ++evidence_.rendered;
        count(verdict, u, v);
        if (((u + v) & 1) != 0) continue;
        for (const auto& [du, dv] : kDirections) {
          if (verdict_at(u + du, v + dv) == kOutside) walk(u, v, du, dv, verdict);
        }
      }
    }
  }

  void count(Verdict verdict, int u, int v) {
    switch (verdict) {
      case kMatched:
        ++evidence_.matched;
        break;
      case kBadNormal:
        ++evidence_.bad_normal;
        break;
      case kSeenThrough:
        ++(near_silhouette(u, v) ? evidence_.seen_through_rim : evidence_.seen_through);
        break;
      case kNearOccluded:
        ++evidence_.near_occluded;
        break;
      case kFarOccluded:
        ++evidence_.far_occluded;
        break;
      case kMissing:
        ++evidence_.missing;
        break;
      case kOnSupport:
        ++evidence_.on_support;
        break;
      case kClaimed:
        ++evidence_.claimed;
        break;
      case kOutside:
        break;
    }
  }

  void add_edge(int u, int v, int du, int dv, int offset) {
    ++evidence_.edges_matched;
    offset_sum_ += static_cast<float>(offset);
    offset_squares_ += static_cast<float>(offset * offset);
    gatherer_.steps_.push_back({window_.u0 + u, window_.v0 + v, du, dv, offset,
                                window_.depth[window_.index(u, v)], outwards(u, v)});
  }

  /// The direction in which the covered part of the neighbourhood thins out.
  [[nodiscard]] Eigen::Vector2f outwards(int u, int v) const {
    constexpr int kReach = 3;
    Eigen::Vector2f inwards = Eigen::Vector2f::Zero();
    for (int dv = -kReach; dv <= kReach; ++dv) {
      for (int du = -kReach; du <= kReach; ++du) {
        if (verdict_at(u + du, v + dv) != kOutside) {
          inwards += Eigen::Vector2f(static_cast<float>(du), static_cast<float>(dv));
        }
      }
    }
    return -inwards.normalized();
  }

  /// From a pixel of the silhouette: where does the scene step back?
  void walk(int u, int v, int du, int dv, Verdict verdict) {
    ++evidence_.edges;
    if (verdict == kSeenThrough) {
      walk_inwards(u, v, du, dv);
    } else if (verdict == kMatched || verdict == kBadNormal) {
      walk_outwards(u, v, du, dv);
    }
  }

  void walk_inwards(int u, int v, int du, int dv) {
    for (int k = 1; k <= kInwardReach; ++k) {
      const Verdict inside = verdict_at(u - k * du, v - k * dv);
      if (inside == kMatched || inside == kBadNormal) {
        return add_edge(u, v, du, dv, -k);
      }
      if (inside != kSeenThrough) return;
    }
    ++evidence_.edges_missed;
  }

  void walk_outwards(int u, int v, int du, int dv) {
    const std::size_t start = window_.index(u, v);
    const float z = window_.depth[start];
    const Eigen::Vector3f n = normal_of(window_.triangle[start]);
    const Eigen::Vector3f p = projection_.point(window_.u0 + u, window_.v0 + v, z);
    const float height = n.dot(p);
    const float pixel = pixel_width_ * z;
    const int reach = std::max(
        kLeastOutwardReach,
        static_cast<int>(std::lround(kLeavesOutward * scene_.octree().leaf_size() / pixel)));
    bool reliable = false;
    bool alike = false;
    for (int k = 1; k <= reach; ++k) {
      const int at_u = window_.u0 + u + k * du;
      const int at_v = window_.v0 + v + k * dv;
      if (at_u < 0 || at_v < 0 || at_u >= projection_.width || at_v >= projection_.height) return;
      const int index = at_v * projection_.width + at_u;
      const ScenePixel& seen = scene_.pixel(index);
      if (!(seen.depth > 0.0f)) return;
      // Where the model's tangent plane would be, and how far from it in depth it is still there.
      const float n_ray = n.dot(projection_.point(at_u, at_v, 1.0f));
      const float farthest = kSteepest * pixel * static_cast<float>(k);
      const float plane = n_ray < -0.05f ? height / n_ray : z + farthest;
      const float behind = seen.depth - std::clamp(plane, z - farthest, z + farthest);
      const float limit = std::sqrt(limit_squared(z, n_ray)) / std::max(-n_ray, 0.3f);
      if (behind > kStepBand * limit) return add_edge(u, v, du, dv, k - 1);
      if (behind < -kContinuedBand * limit) return;  // an occluder or a neighbour in front
      if ((seen.flags & ScenePixel::kSupport) != 0 || is_claimed(index)) return;
      reliable = (seen.flags & ScenePixel::kNormal) != 0;
      alike =
          reliable && n.dot(seen.normal()) > kContinuedNormal && behind < kContinuedBand * limit;
    }
    if (alike) ++evidence_.edges_continued;
  }

  void finish() {
    if (evidence_.matched > 0) {
      const auto matched = static_cast<float>(evidence_.matched);
      evidence_.residual_mean = residual_sum_ / (matched * tolerance_);
      evidence_.residual_rms = std::sqrt(residual_squares_ / matched);
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
      solver.computeDirect(scatter_ / matched, Eigen::EigenvaluesOnly);
      evidence_.second_face = std::max(solver.eigenvalues()[1], 0.0f);
    }
    if (normals_ > 0) evidence_.normal_error = normal_error_ / static_cast<float>(normals_);
    if (evidence_.edges_matched > 0) {
      const auto edges = static_cast<float>(evidence_.edges_matched);
      evidence_.edge_offset = offset_sum_ / edges;
      evidence_.edge_spread = std::sqrt(
          std::max(offset_squares_ / edges - evidence_.edge_offset * evidence_.edge_offset, 0.0f));
    }
  }

  EvidenceGatherer& gatherer_;
  const ObservedScene& scene_;
  const Projection& projection_;
  const RecognitionModel& model_;
  const Eigen::Matrix3f R_;
  const float tolerance_;
  const float pixel_width_;
  const PixelClaims* claims_;
  const std::int32_t claimant_;
  const RenderedModel& window_;

  std::int32_t last_triangle_ = -1;
  Eigen::Vector3f normal_ = Eigen::Vector3f::Zero();
  int run_ = 0;  // matched pixels with the normal
  Eigen::Matrix3f scatter_ = Eigen::Matrix3f::Zero();
  float residual_sum_ = 0.0f;
  float residual_squares_ = 0.0f;
  float normal_error_ = 0.0f;
  int normals_ = 0;
  float offset_sum_ = 0.0f;
  float offset_squares_ = 0.0f;
  HypothesisEvidence evidence_;
};

HypothesisEvidence EvidenceGatherer::gather(const RecognitionModel& model,
                                            const Eigen::Isometry3f& T_camera_model,
                                            const PixelClaims* claims, std::int32_t claimant) {
  HypothesisEvidence evidence = EvidencePass(*this, model, T_camera_model, claims, claimant).run();
  // A convex body's shadow is a quarter of its surface on average (Cauchy).
  const Projection& projection = scene_.projection();
  const float z = std::max((T_camera_model * model.centre).z(), 1e-3f);
  evidence.expected = 0.25f * model.area * projection.fx * projection.fy / (z * z);
  return evidence;
}

void EvidenceGatherer::explained_pixels(std::vector<int>& pixels) const {
  pixels.clear();
  if (rendered_ == nullptr) return;
  std::size_t i = 0;
  for (int v = 0; v < rendered_->height; ++v) {
    for (int u = 0; u < rendered_->width; ++u, ++i) {
      if (verdicts_[i] != kMatched && verdicts_[i] != kBadNormal) continue;
      pixels.push_back((rendered_->v0 + v) * scene_.projection().width + rendered_->u0 + u);
    }
  }
}

int EvidenceGatherer::matched_count(const PixelClaims& claims, std::int32_t claimant) const {
  if (rendered_ == nullptr) return 0;
  int count = 0;
  std::size_t i = 0;
  for (int v = 0; v < rendered_->height; ++v) {
    const std::int32_t* row =
        claims.data() + (rendered_->v0 + v) * scene_.projection().width + rendered_->u0;
    for (int u = 0; u < rendered_->width; ++u, ++i) {
      if (verdicts_[i] == kMatched && (row[u] < 0 || row[u] == claimant)) ++count;
    }
  }
  return count;
}

void EvidenceGatherer::matched_pixels(int stride, std::vector<MatchedPixel>& pixels) const {
  pixels.clear();
  if (rendered_ == nullptr) return;
  const Projection& projection = scene_.projection();
  for (int v = stride / 2; v < rendered_->height; v += stride) {
    for (int u = stride / 2; u < rendered_->width; u += stride) {
      const std::size_t i = rendered_->index(u, v);
      if (verdicts_[i] != kMatched) continue;
      const Eigen::Vector3f ray = projection.point(rendered_->u0 + u, rendered_->v0 + v, 1.0f);
      const auto triangle = static_cast<std::size_t>(rendered_->triangle[i]);
      const Eigen::Vector3f normal = R_camera_model_ * model_->render_mesh.normals[triangle];
      const float z = rendered_->depth[i];
      const int index = (rendered_->v0 + v) * projection.width + rendered_->u0 + u;
      pixels.push_back({z * ray, normal, scene_.pixel(index).depth * ray,
                        sensor_.normal_variance(z, normal.dot(ray), 1.0f / projection.fx)});
    }
  }
}

}  // namespace binpick
