#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "experiments/stopping_rule.h"
#include "experiments/trial_kind.h"
#include "models/config_visitor.h"

namespace binpick {

/// One dimension of a sweep.
struct AxisConfig {
  std::string name;                 ///< in cell keys and tables, e.g. "translation_y"
  std::string key;                  ///< path below `parameters`, e.g. "stiffness.translation_y"
  std::vector<std::string> values;  ///< as written in the file; units and ranges are the key's
  std::vector<std::string> labels;  ///< what tables print; the values themselves when empty
  bool columns = false;             ///< tables put the values of this axis side by side

  void visit(ConfigVisitor& visitor);
  [[nodiscard]] const std::string& label(std::size_t value) const;
};

/// Counts that the paper reports for the cells that `cell` matches: axis name to value, axes that
/// it leaves out match every value.
struct PaperCount {
  std::map<std::string, std::string> cell;
  std::int64_t successes = 0;
  std::int64_t trials = 0;

  void visit(ConfigVisitor& visitor);
};

/// A demand on a rate, pooled over the matching cells (all cells when `cell` is empty). It fails
/// only when the upper end of the 95 % interval lies below `minimum_rate`.
struct GateConfig {
  std::map<std::string, std::string> cell;
  double minimum_rate = 0.0;

  void visit(ConfigVisitor& visitor);
};

/// The version of the experiment file's format; it changes when keys are renamed or change meaning.
inline constexpr std::int64_t kConfigFormat = 1;

/// An experiment as its file states it: cells (the product of the axes) times trials.
///
///     format: 1                            # kConfigFormat; files of another one are refused
///     experiment: table1                   # names results and seeds: letters, digits, _ and -
///     title: Blind grasps of the bottle
///     kind: blind_grasp
///     seed: 2012
///     trials: 10                           # per cell
///     stopping: {half_width: 0.03, block: 50}  # fewer trials where the interval is narrow already
///     time_limit_s: 60                     # per trial, a backstop against hangs; see Runner
///     parameters: {...}                    # the trial kind's own
///     axes:
///       - {name: translation_y, key: stiffness.translation_y, values: [200, 750, 2000]}
///       - {name: reaction, key: reaction, values: [true, false], labels: ["on", "off"],
///          columns: true}
///     paper:
///       - {cell: {translation_y: 200}, successes: 23, trials: 30}
///     gates:
///       - {cell: {translation_y: 200}, minimum_rate: 0.7}
///       - {minimum_rate: 0.5}
struct ExperimentConfig {
  std::int64_t format = kConfigFormat;
  std::string name;
  std::string title;
  std::string kind;
  std::int64_t seed = 1;
  std::int64_t trials = 10;
  StoppingRule stopping;
  double time_limit = 60.0;  ///< s
  std::vector<AxisConfig> axes;
  std::vector<PaperCount> paper;
  std::vector<GateConfig> gates;

  /// What pages and tables are headed by: the title or, without one, the name.
  [[nodiscard]] const std::string& heading() const { return title.empty() ? name : title; }

  /// Visits all keys. `parameters` is made from `registry` as soon as the kind's name is known.
  void visit(ConfigVisitor& visitor, const TrialKindRegistry& registry,
             std::unique_ptr<TrialKind>& parameters);

 private:
  void visit_sweep(ConfigVisitor& visitor, const TrialKindRegistry& registry,
                   TrialKind* parameters);
};

}  // namespace binpick
