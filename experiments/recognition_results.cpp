#include "experiments/recognition_results.h"

#include <cmath>
#include <map>
#include <string_view>

namespace binpick {
namespace {

using Measures = std::map<std::string, double>;

double value_of(const Measures& measures, const std::string& name) {
  const auto found = measures.find(name);
  return found == measures.end() ? 0.0 : found->second;
}

/// Appends the measure `name`, or all measures `name.<i>`.
void append(const Measures& measures, std::string_view name, std::vector<double>& values) {
  for (auto each = measures.lower_bound(std::string(name)); each != measures.end(); ++each) {
    if (!each->first.starts_with(name)) break;
    const std::string_view rest = std::string_view(each->first).substr(name.size());
    if (rest.empty() || rest.front() == '.') values.push_back(each->second);
  }
}

void add_found(const Measures& measures, const std::string& group, Proportion& proportion) {
  proportion.trials += std::llround(value_of(measures, group));
  proportion.successes += std::llround(value_of(measures, group + "_found"));
}

void add(const TrialRecord& record, RecognitionCell& cell) {
  const Measures& measures = record.measures;
  ++cell.trials;
  ++cell.success.trials;
  cell.success.successes += record.outcome == TrialOutcome::kSuccess ? 1 : 0;
  add_found(measures, "visible", cell.visible);
  add_found(measures, "hidden", cell.hidden);
  cell.false_positives += value_of(measures, "false_positives");
  append(measures, "position_m", cell.positions);
  append(measures, "rotation_rad", cell.rotations);
  append(measures, "rms_share", cell.rms_shares);
  append(measures, "position_share", cell.position_shares);
  append(measures, "pairs", cell.pairs);
  append(measures, "scene_points", cell.points);
  append(measures, "wall_s", cell.wall);
  append(measures, "cpu_s", cell.cpu);
}

}  // namespace

std::vector<RecognitionCell> recognition_cells(const Experiment& experiment,
                                               const TrialTable& trials) {
  const std::vector<AxisConfig>& axes = experiment.config().axes;
  std::vector<RecognitionCell> cells;
  for (const Cell& cell : experiment.cells()) {
    RecognitionCell& result = cells.emplace_back();
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      result.values.push_back(axes[axis].values[cell.values[axis]]);
      result.labels.push_back(axes[axis].label(cell.values[axis]));
    }
    const auto last = trials.lower_bound({cell.key, experiment.config().trials});
    for (auto each = trials.lower_bound({cell.key, 0}); each != last; ++each) {
      add(each->second.record, result);
    }
  }
  return cells;
}

}  // namespace binpick
