#include "recognition/render_verification.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace binpick {
namespace {

// The weights and limits were chosen on synthetic piles under structured-light noise; the terms'
// order of importance is near occlusion, ragged, continued silhouette, normals.
constexpr double kNearOcclusionWeight = 1.5;
constexpr double kRaggedWeight = 1.0;
constexpr double kContinuedWeight = 0.5;
constexpr double kMostBadness = 0.155;
constexpr double kFullEvidence = 0.7;  // of a typical view: less evidence tightens the limit
constexpr double kTightestFactor = 0.4;
constexpr float kNearOcclusionBands = 4.0f;
constexpr float kLikeNormal = 0.77f;       // 40 degrees
constexpr float kContinuedNormal = 0.94f;  // 20 degrees
constexpr float kBeyondSilhouette = 1.6f;  // leaves: beyond the dilation of a silhouette
constexpr int kRaggedWidth = 2;

enum class Verdict { kNeutral, kMatched, kBadNormal, kViolating, kNearOccluded };

class Comparison {
 public:
  Comparison(const ObservedScene& scene, const RecognitionModel& model,
             const Eigen::Isometry3f& T_camera_model, const RenderedModel& rendered, float epsilon)
      : scene_(scene),
        model_(model),
        R_(T_camera_model.linear()),
        rendered_(rendered),
        epsilon_(epsilon) {}

  RenderComparison run() {
    for (int v = 0; v < rendered_.height; ++v) {
      for (int u = 0; u < rendered_.width; ++u) {
        if (rendered_.covers(u, v)) count_pixel(u, v);
      }
    }
    result_.continued = silhouette_ > 0 ? static_cast<double>(continued_) / silhouette_ : 0.0;
    std::sort(result_.explained.begin(), result_.explained.end());
    result_.explained.erase(std::unique(result_.explained.begin(), result_.explained.end()),
                            result_.explained.end());
    return std::move(result_);
  }

 private:
  [[nodiscard]] Eigen::Vector3f normal_at(int u, int v) const {
    const std::int32_t triangle = rendered_.triangle[rendered_.index(u, v)];
    return R_ * model_.render_mesh.normals[static_cast<std::size_t>(triangle)];
  }
  [[nodiscard]] int image_index(int u, int v) const {
    return (rendered_.v0 + v) * scene_.projection().width + rendered_.u0 + u;
  }
  [[nodiscard]] Eigen::Vector3f model_point(int u, int v) const {
    return scene_.projection().point(rendered_.u0 + u, rendered_.v0 + v,
                                     rendered_.depth[rendered_.index(u, v)]);
  }

  [[nodiscard]] Verdict judge(int u, int v, const Eigen::Vector3f& n) const {
    const int index = image_index(u, v);
    const ScenePixel& pixel = scene_.pixel(index);
    if (!(pixel.depth > 0.0f)) return Verdict::kNeutral;
    const Eigen::Vector3f p = model_point(u, v);
    const float in_front = n.dot(scene_.projection().point(index, pixel.depth) - p);
    if (in_front < -epsilon_) return Verdict::kViolating;
    if (in_front > epsilon_) {
      return in_front < kNearOcclusionBands * epsilon_ ? Verdict::kNearOccluded : Verdict::kNeutral;
    }
    if ((pixel.flags & ScenePixel::kSupport) != 0) return Verdict::kNeutral;
    if ((pixel.flags & ScenePixel::kNormal) != 0 && n.dot(pixel.normal()) < kLikeNormal) {
      return Verdict::kBadNormal;
    }
    return Verdict::kMatched;
  }

  void count_pixel(int u, int v) {
    ++result_.rendered;
    const Eigen::Vector3f n = normal_at(u, v);
    switch (judge(u, v, n)) {
      case Verdict::kMatched: {
        ++result_.matched;
        const int leaf = scene_.leaf_of_pixel(image_index(u, v));
        if (leaf >= 0) result_.explained.push_back(leaf);
        break;
      }
      case Verdict::kBadNormal:
        ++result_.bad_normal;
        break;
      case Verdict::kNearOccluded:
        ++result_.near_occluded;
        break;
      case Verdict::kViolating:
        ++(near_silhouette(u, v) ? result_.ragged : result_.violating);
        break;
      case Verdict::kNeutral:
        break;
    }
    count_silhouette(u, v, n);
  }

  [[nodiscard]] bool near_silhouette(int u, int v) const {
    for (int step = 1; step <= kRaggedWidth; ++step) {
      if (!rendered_.covers(u - step, v) || !rendered_.covers(u + step, v) ||
          !rendered_.covers(u, v - step) || !rendered_.covers(u, v + step)) {
        return true;
      }
    }
    return false;
  }

  /// If (u, v) lies on the silhouette: does the scene go on beyond it as if the surface did?
  void count_silhouette(int u, int v, const Eigen::Vector3f& n) {
    constexpr std::array<std::array<int, 2>, 4> kSteps = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    for (const auto& [du, dv] : kSteps) {
      if (rendered_.covers(u + du, v + dv)) continue;
      ++silhouette_;
      const Eigen::Vector3f p = model_point(u, v);
      const float step_pixels =
          kBeyondSilhouette * scene_.octree().leaf_size() * scene_.projection().fx / p.z();
      const int steps = std::max(2, static_cast<int>(std::lround(step_pixels)));
      if (rendered_.covers(u + steps * du, v + steps * dv)) continue;
      if (goes_on_at(rendered_.u0 + u + steps * du, rendered_.v0 + v + steps * dv, p, n)) {
        ++continued_;
      }
    }
  }

  [[nodiscard]] bool goes_on_at(int u, int v, const Eigen::Vector3f& p,
                                const Eigen::Vector3f& n) const {
    const Projection& projection = scene_.projection();
    if (u < 0 || v < 0 || u >= projection.width || v >= projection.height) return false;
    const int index = v * projection.width + u;
    const ScenePixel& pixel = scene_.pixel(index);
    if (!(pixel.depth > 0.0f) || (pixel.flags & ScenePixel::kNormal) == 0) return false;
    const Eigen::Vector3f q = projection.point(index, pixel.depth);
    return std::abs(n.dot(q - p)) < epsilon_ && n.dot(pixel.normal()) > kContinuedNormal;
  }

  const ObservedScene& scene_;
  const RecognitionModel& model_;
  const Eigen::Matrix3f R_;
  const RenderedModel& rendered_;
  const float epsilon_;
  int silhouette_ = 0;
  int continued_ = 0;
  RenderComparison result_;
};

}  // namespace

double RenderComparison::badness() const {
  const int decided = matched + bad_normal + violating + ragged + near_occluded;
  if (decided == 0) return 1.0;
  const double contradicting =
      bad_normal + violating + kRaggedWeight * ragged + kNearOcclusionWeight * near_occluded;
  return contradicting / decided + kContinuedWeight * continued;
}

double RenderComparison::matched_share() const {
  return rendered > 0 ? static_cast<double>(matched) / rendered : 0.0;
}

bool RenderComparison::accepts(double least_matched_share) const {
  if (matched_share() < least_matched_share) return false;
  const double evidence = expected > 0.0 ? matched / expected : 0.0;
  return badness() < kMostBadness * std::clamp(evidence / kFullEvidence, kTightestFactor, 1.0);
}

RenderComparison compare_by_rendering(DepthRasterizer& rasterizer, const ObservedScene& scene,
                                      const RecognitionModel& model,
                                      const Eigen::Isometry3f& T_camera_model, float epsilon) {
  const RenderedModel& rendered =
      rasterizer.render(model.render_mesh, T_camera_model, scene.projection());
  RenderComparison result = Comparison(scene, model, T_camera_model, rendered, epsilon).run();
  // A convex body's shadow is a quarter of its surface on average (Cauchy).
  const Projection& projection = scene.projection();
  const float z = std::max((T_camera_model * model.centre).z(), 1e-3f);
  result.expected =
      0.25 * static_cast<double>(model.area * projection.fx * projection.fy / (z * z));
  return result;
}

}  // namespace binpick
