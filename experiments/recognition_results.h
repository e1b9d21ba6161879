#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/proportions.h"
#include "experiments/result_store.h"

namespace binpick {

/// The measures of one cell of a recognition experiment, over its trials.
struct RecognitionCell {
  std::vector<std::string> values;  ///< of the axes
  std::vector<std::string> labels;  ///< of the same
  std::int64_t trials = 0;
  Proportion success;          ///< of trials
  Proportion visible, hidden;  ///< objects found
  double false_positives = 0.0;
  std::vector<double> positions, rotations;         ///< m, rad; of the objects found
  std::vector<double> rms_shares, position_shares;  ///< of the diagonal; of the objects found
  std::vector<double> pairs, points, wall, cpu;     ///< one per trial

  /// Objects of visible share 0.15 and more.
  [[nodiscard]] Proportion seen() const {
    return {visible.successes + hidden.successes, visible.trials + hidden.trials};
  }
};

/// By cell index.
[[nodiscard]] std::vector<RecognitionCell> recognition_cells(const Experiment& experiment,
                                                             const TrialTable& trials);

}  // namespace binpick
