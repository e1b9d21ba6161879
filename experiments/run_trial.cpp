#include "experiments/run_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>

namespace binpick {
namespace {

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

}  // namespace

TrialRun run_trial(TrialKind& kind, const TrialContext& context) {
  const StageWatch watch(context);
  try {
    TrialRecord record = kind.run(watch.context());
    record.note = one_line(record.note);
    return {std::move(record), true};
  } catch (const std::exception& error) {
    return {{TrialOutcome::kCrashed,
             watch.stage(),
             one_line(fmt::format("threw: {}", error.what())),
             {}},
            false};
  } catch (...) {
    return {
        {TrialOutcome::kCrashed, watch.stage(), "threw something that is no std::exception", {}},
        false};
  }
}

TrialRecord run_single_trial(const Experiment& experiment, const Cell& cell,
                             const TrialContext& context) {
  const std::unique_ptr<TrialKind> kind = experiment.make_kind();
  experiment.assign(cell, *kind);
  kind->prepare(experiment.directory());
  return run_trial(*kind, context).record;
}

}  // namespace binpick
