#include <gtest/gtest.h>

#include <cmath>

#include "experiments/experiment.h"
#include "experiments/run_trial.h"
#include "experiments/standard_trial_kinds.h"

namespace binpick {
namespace {

Experiment experiment_of(const std::string& name) {
  return Experiment::load(std::string(BINPICK_SOURCE_DIR) + "/experiments/" + name + ".yaml", {},
                          standard_trial_kinds());
}

TrialContext context_of(const Experiment& experiment, const Cell& cell, std::int64_t trial) {
  return {experiment.seeds(cell, trial), trial, {}, {}, {}};
}

TEST(RecognitionTrial, RecordsDoNotDependOnWhatRanBefore) {
  const Experiment experiment = experiment_of("fig12");
  const Cell& cell = experiment.cell("sigma_percent=0.05,setting=default");
  const Cell& other = experiment.cell("sigma_percent=0.3,setting=default");
  const std::unique_ptr<TrialKind> kind = experiment.make_kind();
  const auto run = [&](const Cell& each, std::int64_t trial) {
    experiment.assign(each, *kind);
    kind->prepare(experiment.directory());
    return kind->run(context_of(experiment, each, trial));
  };
  const TrialRecord first = run(cell, 0);
  (void)run(other, 0);
  (void)run(other, 1);
  EXPECT_TRUE(identical(run(cell, 0), first));
  EXPECT_TRUE(
      identical(run_single_trial(experiment, cell, context_of(experiment, cell, 0)), first));
  EXPECT_GT(first.measures.at("visible"), 0.0);
}

TEST(RecognitionTrial, TargetsHaveTheWantedOcclusion) {
  const Experiment experiment = experiment_of("fig13a");
  for (const char* key :
       {"model=ram,occlusion=0.70,setting=default", "model=gnome,occlusion=0.85,setting=default"}) {
    const Cell& cell = experiment.cell(key);
    const TrialRecord record = run_single_trial(experiment, cell, context_of(experiment, cell, 0));
    const double wanted = std::string(key).find("0.70") != std::string::npos ? 0.70 : 0.85;
    EXPECT_NEAR(record.measures.at("target_occlusion"), wanted, 0.02) << key;
  }
}

TEST(RecognitionTrial, FindsMostOfANominalPileWithinMillimetres) {
  const Experiment experiment = experiment_of("recognition");
  const Cell& cell = experiment.cell("variant=nominal,setting=default");
  double visible = 0.0;
  double found = 0.0;
  for (std::int64_t trial = 0; trial < 3; ++trial) {
    const TrialRecord record =
        run_single_trial(experiment, cell, context_of(experiment, cell, trial));
    visible += record.measures.at("visible");
    found += record.measures.at("visible_found");
    for (const auto& [name, value] : record.measures) {
      EXPECT_TRUE(!name.starts_with("position_m") || value < 0.01) << name << ' ' << value;
    }
  }
  EXPECT_GE(visible, 9.0);
  EXPECT_GE(found, 0.7 * visible);
}

}  // namespace
}  // namespace binpick
