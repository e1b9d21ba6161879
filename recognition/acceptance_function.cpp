#include "recognition/acceptance_function.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace binpick {
Acceptance evaluate_acceptance(const ObservedScene& scene, const RecognitionModel& model,
                               const Eigen::Isometry3f& T_camera_model, float epsilon) {
  const TestPoints& points = model.test_points;
  const Eigen::Matrix3f R = T_camera_model.linear();
  const Eigen::Vector3f t = T_camera_model.translation();
  int visible = 0;
  int occluding = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = R * points.p(i) + t;
    const int index = scene.projection().pixel(p);
    if (index < 0) continue;
    const ScenePixel& pixel = scene.pixel(index);
    if (!(pixel.depth > 0.0f)) continue;
    const float behind = pixel.depth - p.z();
    if (behind > epsilon) {
      ++occluding;
    } else if (behind >= -epsilon && (pixel.flags & ScenePixel::kSupport) == 0) {
      ++visible;
    }
  }
  const auto m = static_cast<double>(points.size());
  return {visible / m, occluding / m};
}

FacingCounts count_facing(const ObservedScene& scene, const RecognitionModel& model,
                          const Eigen::Isometry3f& T_camera_model, float epsilon, std::size_t begin,
                          std::size_t end) {
  static const PointKernels kernels = best_kernels();
  return kernels.count_facing(scene, model, T_camera_model, epsilon, begin, end);
}

std::optional<FacingCounts> test_in_cascade(const ObservedScene& scene,
                                            const RecognitionModel& model,
                                            const Eigen::Isometry3f& T_camera_model,
                                            const FacingThresholds& thresholds) {
  constexpr std::array<std::size_t, 3> kStages = {32, 128, 256};
  FacingCounts counts;
  std::size_t begin = 0;
  for (const std::size_t end : kStages) {
    const FacingCounts more =
        count_facing(scene, model, T_camera_model, thresholds.epsilon, begin, end);
    counts.facing += more.facing;
    counts.matched += more.matched;
    counts.occluding += more.occluding;
    begin = end;
    const auto facing = static_cast<float>(counts.facing);
    const auto slack = [&](float share) {
      return end == kStages.back() ? 0.0f : 2.0f * std::sqrt(share * (1.0f - share) * facing);
    };
    const float least = thresholds.visibility * facing - slack(thresholds.visibility);
    const float most = thresholds.penalty * facing + slack(thresholds.penalty);
    if (counts.matched < 1 || static_cast<float>(counts.matched) < least ||
        static_cast<float>(counts.occluding) > most) {
      return std::nullopt;
    }
  }
  return counts;
}

bool sinks_into_support(const ObservedScene& scene, const RecognitionModel& model,
                        const Eigen::Isometry3f& T_camera_model, float depth) {
  for (const SupportPlane& plane : scene.support_planes()) {
    const Eigen::Vector3f normal = plane.normal.cast<float>();
    // The plane in model coordinates: one product instead of one per point.
    const Eigen::Vector3f n = T_camera_model.linear().transpose() * normal;
    const float offset =
        static_cast<float>(plane.offset) - normal.dot(T_camera_model.translation());
    for (const Eigen::Vector3f& p : model.hull) {
      if (n.dot(p) - offset < -depth) return true;
    }
  }
  return false;
}

}  // namespace binpick
