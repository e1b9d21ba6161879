#include "experiments/result_markdown.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "coin_experiment.h"
#include "experiments/text_table.h"
#include "models/errors.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Coins that land well in the first `successes(cell)` trials of each cell.
template <class Successes>
RunResults results_with(const Experiment& experiment, const Successes& successes) {
  RunResults results{RunManifest::of(experiment), {}, {}};
  for (const Cell& cell : experiment.cells()) {
    for (std::int64_t trial = 0; trial < experiment.config().trials; ++trial) {
      StoredTrial stored;
      if (trial >= successes(cell)) stored.record.outcome = TrialOutcome::kSlipped;
      results.trials[{cell.key, trial}] = stored;
    }
  }
  return results;
}

std::string markdown(const Experiment& experiment, const RunResults& results) {
  return result_markdown(experiment, results, summarize(experiment, results.trials));
}

/// Table 1's nine stiffness pairs, and with `values` another axis; 40 trials per cell.
Experiment plane_experiment(const std::string& values = "") {
  std::string yaml =
      "experiment: plane\ntitle: Plane\nkind: coin\nseed: 1\ntrials: 40\nparameters: {rate: 0.5}\n"
      "axes:\n"
      "  - {name: K_t_y, key: fault_period, values: [200, 750, 2000]}\n"
      "  - {name: K_r_x, key: work_ms, values: [20, 75, 200]}\n";
  if (!values.empty()) yaml += "  - {name: error, key: rate, values: [" + values + "]}\n";
  return coin_experiment(yaml);
}

std::int64_t soft_is_better(const Cell& cell) {
  const std::array<std::int64_t, 3> by_translation{38, 20, 4};
  return by_translation[cell.values[0]];
}

TEST(TextTable, IsATableInMarkdownToo) {
  TextTable table({"cell", "%"});
  table.add_row({"a", "50"});
  table.add_row({"b"});
  EXPECT_EQ(table.markdown(), "| cell | % |\n| :-- | --: |\n| a | 50 |\n| b |  |\n");
}

TEST(ResultMarkdown, SaysOursBesideThePapersAndWhatItSupports) {
  const Experiment experiment = coin_experiment();
  const auto half = [](const Cell&) { return std::int64_t{10}; };
  const std::string text = markdown(experiment, results_with(experiment, half));
  EXPECT_THAT(text, HasSubstr("### Coins <heads> & tails\n"));
  EXPECT_THAT(text, HasSubstr("120 of 120 trials, experiment `coin`, seed 3"));
  EXPECT_THAT(text, HasSubstr("| 0.9 | 10/20 | 50.0 | [29.9, 70.1] | no, p=0.049 | 10/20 "));
  EXPECT_THAT(text, HasSubstr("* all cells (side up): 30/60 = 50.0 %"));
  EXPECT_THAT(text, HasSubstr("bootstrap p = "));
  EXPECT_THAT(text, HasSubstr("| slipped | judge | 60 | 50.0 |"));
}

TEST(ResultMarkdown, APlaneIsAMapWithItsClaims) {
  const Experiment experiment = plane_experiment();
  const std::string text = markdown(experiment, results_with(experiment, soft_is_better));
  EXPECT_THAT(text, HasSubstr("| K_t,y \\ K_r,x | 20 | 75 | 200 |"));
  EXPECT_THAT(text, HasSubstr("| 2000 | 10.0 [4.0, 23.1] |"));
  EXPECT_THAT(text, HasSubstr("| all trials | 360 | 51.7 [44.0, 59.3] | +85.0 ["));
  EXPECT_THAT(text, HasSubstr(", confirmed |"));
  EXPECT_THAT(text, HasSubstr("| worlds of one flat rate |  | 66.7 % | confirmed in "));
}

TEST(ResultMarkdown, ASweepHasOneRowPerValue) {
  const Experiment experiment = plane_experiment("0.1, 0.2, 0.3, 0.4, 0.5");
  const auto stiff_is_better = [](const Cell& cell) { return 40 - soft_is_better(cell); };
  const std::string text = markdown(experiment, results_with(experiment, stiff_is_better));
  for (const char* value : {"0.1", "0.2", "0.3", "0.4", "0.5"}) {
    EXPECT_THAT(text, HasSubstr(fmt::format("| error {} | 360 | 48.3 ", value)));
  }
  EXPECT_THAT(text, HasSubstr("-85.0 ["));
  EXPECT_THAT(text, HasSubstr(", contradicted |"));
  EXPECT_THAT(text, Not(HasSubstr("\\ K_r,x")));
}

TEST(ResultMarkdown, PairsTheTrialsOfTwoRuns) {
  const Experiment experiment = coin_experiment();
  const RunResults better = results_with(experiment, [](const Cell&) { return 15; });
  const RunResults worse = results_with(experiment, [](const Cell&) { return 12; });
  const auto pairs = compare_runs(experiment, better.trials, experiment, worse.trials);
  ASSERT_EQ(pairs.size(), 7u);
  EXPECT_EQ(pairs[0].only_first, 3);
  EXPECT_EQ(pairs[0].only_second, 0);
  EXPECT_EQ(pairs[6].only_first, 18);
  EXPECT_THAT(paired_markdown(pairs, "best", "paper"),
              HasSubstr("| all cells | 18 | 0 | p = 7.6e-06 |"));
}

TEST(ResultMarkdown, RunsWithoutCommonTrialsAreNotPaired) {
  std::string yaml = kCoinYaml;
  yaml.replace(yaml.find("seed: 3"), 7, "seed: 4");
  const Experiment first = coin_experiment();
  EXPECT_THROW((void)compare_runs(first, {}, coin_experiment(yaml), {}), InputError);
  EXPECT_THROW((void)compare_runs(first, {}, plane_experiment(), {}), InputError);
}

}  // namespace
}  // namespace binpick
