#pragma once

#include <span>
#include <vector>

#include "models/detection.h"
#include "recognition/model_library.h"
#include "recognition/pose_metrics.h"
#include "recognition/recognizer.h"
#include "recognition/synthetic_scene.h"

namespace binpick::testing {

/// Searches a frame in the form in which it comes.
[[nodiscard]] RecognitionResult recognize(const Recognizer& recognizer, const SyntheticFrame& frame,
                                          Seed seed);

/// Which detections of one frame are right: those whose MSSD to a true instance of their model is
/// below a tenth of the diameter. Each true instance is matched once, nearest first.
struct FrameScore {
  struct Match {
    std::size_t detection = 0;
    std::size_t instance = 0;
    double mssd = 0.0;
    PoseError error;
  };
  std::vector<Match> matches;
  std::vector<std::size_t> false_detections;
  std::vector<bool> found;  ///< per true instance
};
[[nodiscard]] FrameScore score_frame(std::span<const Detection> detections,
                                     const SyntheticFrame& frame,
                                     std::span<const RecognitionModel> models);

/// Sums over frames. Objects that leave the image are no misses.
struct Tally {
  int frames = 0;
  int visible = 0, found = 0;        ///< instances that show at least 30 %
  int hidden = 0, hidden_found = 0;  ///< instances that show 15 to 30 %
  int false_positives = 0;
  std::vector<double> positions, rotations;  ///< errors of right detections, m and rad

  void add(const FrameScore& score, const SyntheticFrame& frame);
};

/// Bounds of Wilson's 95 % interval of a proportion; [0, 1] without trials.
struct Wilson {
  double low = 0.0;
  double high = 1.0;
};
[[nodiscard]] Wilson wilson(int successes, int trials);

/// The value below which `share` of the values lie; 0 when there are none.
[[nodiscard]] double quantile(std::vector<double> values, double share);

}  // namespace binpick::testing
