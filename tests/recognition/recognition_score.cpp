#include "recognition/recognition_score.h"

#include <algorithm>
#include <cmath>

namespace binpick::testing {

RecognitionResult recognize(const Recognizer& recognizer, const SyntheticFrame& frame, Seed seed) {
  return frame.parameters.form == ScanForm::kRangeImage
             ? recognizer.recognize(frame.image, seed)
             : recognizer.recognize(frame.cloud, frame.p_scene_viewpoint, seed);
}

FrameScore score_frame(std::span<const Detection> detections, const SyntheticFrame& frame,
                       std::span<const RecognitionModel> models) {
  constexpr double kMostError = 0.1;  // of the diameter
  const std::vector<TrueInstance>& instances = frame.scene.instances;
  std::vector<FrameScore::Match> candidates;
  for (std::size_t d = 0; d < detections.size(); ++d) {
    for (std::size_t i = 0; i < instances.size(); ++i) {
      const RecognitionModel& model = models[instances[i].model];
      if (detections[d].model != model.name) continue;
      const Eigen::Isometry3d& T_estimated = detections[d].T_scene_model;
      const Eigen::Isometry3d T_true = frame.T_scene_camera * instances[i].T_camera_model;
      const double error = mssd(T_estimated, T_true, model.hull, model.symmetries);
      if (error < kMostError * static_cast<double>(model.diameter)) {
        candidates.push_back({d, i, error, pose_error(T_estimated, T_true, model.symmetries)});
      }
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.mssd < b.mssd; });
  FrameScore score;
  score.found.assign(instances.size(), false);
  std::vector<bool> right(detections.size(), false);
  for (const FrameScore::Match& match : candidates) {
    if (right[match.detection] || score.found[match.instance]) continue;
    right[match.detection] = true;
    score.found[match.instance] = true;
    score.matches.push_back(match);
  }
  for (std::size_t d = 0; d < detections.size(); ++d) {
    if (!right[d]) score.false_detections.push_back(d);
  }
  return score;
}

void Tally::add(const FrameScore& score, const SyntheticFrame& frame) {
  ++frames;
  false_positives += static_cast<int>(score.false_detections.size());
  for (const FrameScore::Match& match : score.matches) {
    positions.push_back(match.error.translation);
    rotations.push_back(match.error.rotation);
  }
  for (std::size_t i = 0; i < score.found.size(); ++i) {
    const TrueInstance& instance = frame.scene.instances[i];
    if (!instance.in_frame || instance.visible_share < 0.15) continue;
    const bool is_visible = instance.visible_share >= 0.3;
    ++(is_visible ? visible : hidden);
    if (score.found[i]) ++(is_visible ? found : hidden_found);
  }
}

Wilson wilson(int successes, int trials) {
  if (trials == 0) return {};
  constexpr double kZ = 1.959964;
  const double n = trials;
  const double p = successes / n;
  const double centre = p + kZ * kZ / (2.0 * n);
  const double half = kZ * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  return {(centre - half) / (1.0 + kZ * kZ / n), (centre + half) / (1.0 + kZ * kZ / n)};
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto n = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + n, values.end());
  return values[static_cast<std::size_t>(n)];
}

}  // namespace binpick::testing
