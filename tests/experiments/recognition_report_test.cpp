#include "experiments/recognition_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coin_experiment.h"
#include "experiments/recognition_results.h"
#include "experiments/report_plot.h"
#include "experiments/standard_trial_kinds.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

Experiment experiment_of(const std::string& name) {
  return Experiment::load(std::string(BINPICK_SOURCE_DIR) + "/experiments/" + name + ".yaml",
                          {{"trials", "20"}}, standard_trial_kinds());
}

/// The same record for all trials of a cell.
TrialTable table_of(const Experiment& experiment,
                    const std::function<TrialRecord(const Cell&)>& record) {
  TrialTable table;
  for (const Cell& cell : experiment.cells()) {
    for (std::int64_t trial = 0; trial < experiment.config().trials; ++trial) {
      table[{cell.key, trial}] = {record(cell), 0.1};
    }
  }
  return table;
}

TEST(RecognitionConfigs, AllCanBeRead) {
  for (const char* name :
       {"recognition", "fig10", "fig12", "fig13a", "fig13b", "fig13b_objects", "fig13c"}) {
    const Experiment experiment = experiment_of(name);
    EXPECT_EQ(experiment.config().name, name);
    EXPECT_NE(recognition_section(experiment, {}), "") << name;
  }
  EXPECT_EQ(experiment_of("fig12").cells().size(), 24U);
  EXPECT_EQ(experiment_of("fig13b").cells().size(), 22U);
}

TEST(RecognitionReport, OtherExperimentsHaveNoSection) {
  EXPECT_EQ(recognition_section(coin_experiment(), {}), "");
}

TEST(RecognitionReport, TimeAgainstPointsHasItsLine) {
  const Experiment experiment = experiment_of("fig13b");
  const TrialTable table = table_of(experiment, [](const Cell& cell) {
    const double points = 20'000.0 * (1.0 + static_cast<double>(cell.values[0]));
    return TrialRecord{TrialOutcome::kSuccess,
                       TrialStage::kJudge,
                       "",
                       {{"scene_points", points}, {"wall_s", 0.010 + 1e-6 * points}}};
  });
  EXPECT_THAT(recognition_section(experiment, table),
              HasSubstr("Setting default: 10.0 ms + 1.000 ms per thousand points, R^2 = 1.000 over "
                        "11 scenes."));
}

TEST(RecognitionReport, SpeedUpIsTheRatioOfTimes) {
  const Experiment experiment = experiment_of("fig13c");
  const TrialTable table = table_of(experiment, [](const Cell& cell) {
    const double seconds = cell.values[0] == 0 ? 0.2 : 0.1;
    return TrialRecord{TrialOutcome::kSuccess, TrialStage::kJudge, "", {{"wall_s", seconds}}};
  });
  EXPECT_THAT(recognition_section(experiment, table),
              HasSubstr("Setting paper: 2 threads are 2.00 times [2.00, 2.00] as fast as one."));
}

TEST(RecognitionResults, CountObjectsAndPoolTheirErrors) {
  const Experiment experiment = experiment_of("recognition");
  const TrialTable table = table_of(experiment, [](const Cell&) {
    return TrialRecord{TrialOutcome::kWrongPose,
                       TrialStage::kRecognize,
                       "",
                       {{"visible", 5.0},
                        {"visible_found", 4.0},
                        {"hidden", 2.0},
                        {"hidden_found", 1.0},
                        {"false_positives", 1.0},
                        {"position_m.0", 0.001},
                        {"position_m.3", 0.003}}};
  });
  const RecognitionCell cell = recognition_cells(experiment, table).front();
  EXPECT_EQ(cell.visible.successes, 80);
  EXPECT_EQ(cell.visible.trials, 100);
  EXPECT_EQ(cell.seen().trials, 140);
  EXPECT_EQ(cell.positions.size(), 40U);
  EXPECT_EQ(cell.false_positives, 20.0);
  EXPECT_EQ(cell.success.successes, 0);
  EXPECT_THAT(recognition_section(experiment, table), HasSubstr("80/100 80.0 % [71.1, 86.7]"));
}

TEST(ReportPlot, PutsPointsWhereTheyBelong) {
  XyPlot plot;
  plot.title = "a < b";
  plot.series = {{"one", {{0.0, 0.0, {}}, {1.0, 1.0, Interval{0.5, 1.0}}}, true}};
  plot.y_max = 1.0;
  const std::string svg = xy_plot_svg(plot);
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, Not(HasSubstr("a < b")));
  // The axis spans 46 to 330 px across, with a margin of a twentieth, and 210 to 26 px up.
  EXPECT_THAT(svg, HasSubstr("cx=\"58.9\" cy=\"210.0\""));
  EXPECT_THAT(svg, HasSubstr("cx=\"317.1\" cy=\"26.0\""));
  EXPECT_THAT(svg, HasSubstr("y1=\"118.0\" x2=\"317.1\" y2=\"26.0\""));
}

}  // namespace
}  // namespace binpick
