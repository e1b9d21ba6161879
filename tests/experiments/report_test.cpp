#include "experiments/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <set>

#include "coin_experiment.h"
#include "experiments/reproduce_line.h"
#include "experiments/result_summary.h"
#include "experiments/result_table.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

RunResults coin_results(const Experiment& experiment) {
  RunResults results{RunManifest::of(experiment), {}, {}};
  const auto kind = experiment.make_kind();
  for (const Cell& cell : experiment.cells()) {
    experiment.assign(cell, *kind);
    for (std::int64_t trial = 0; trial < experiment.config().trials; ++trial) {
      const TrialContext context{experiment.seeds(cell, trial), trial, {}, {}, {}};
      results.trials[{cell.key, trial}] = {kind->run(context), 0.1};
    }
  }
  return results;
}

Experiment hostile_experiment() {
  std::string yaml = kCoinYaml;
  const std::string plain = "rate: 0.6, work_ms: 0";
  yaml.replace(yaml.find(plain), plain.size(),
               "rate: 0.6, note: \"</td><script>alert('1')</script> & \\\"more\\\"\"");
  return coin_experiment(yaml);
}

/// The name of the element that is left open or wrongly closed; empty when all is well.
std::string first_unbalanced_element(const std::string& html) {
  const std::set<std::string> empty_elements{"meta", "line", "rect"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "end of file";
    const bool closing = html[at + 1] == '/';
    std::string name;
    for (std::size_t i = at + 1 + (closing ? 1 : 0);
         i < end && std::isalnum(static_cast<unsigned char>(html[i])) != 0; ++i) {
      name += html[i];
    }
    if (name.empty() || html[end - 1] == '/') continue;
    if (closing) {
      if (open.empty() || open.back() != name) return name;
      open.pop_back();
    } else if (!empty_elements.contains(name)) {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : open.back();
}

TEST(Report, IsWellFormedAndSelfContained) {
  const Experiment experiment = hostile_experiment();
  const std::string html = report_html(experiment, coin_results(experiment), "results/coin");
  EXPECT_EQ(first_unbalanced_element(html), "");
  EXPECT_THAT(html, Not(HasSubstr("http")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_THAT(html, HasSubstr("<svg"));
}

TEST(Report, EscapesEverything) {
  const Experiment experiment = hostile_experiment();
  const std::string html = report_html(experiment, coin_results(experiment), "a <folder>'s");
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<heads>")));
  EXPECT_THAT(html, Not(HasSubstr("<folder>")));
  EXPECT_THAT(html, HasSubstr("Coins &lt;heads&gt; &amp; tails"));
}

TEST(Report, IsAFunctionOfTheResults) {
  const Experiment experiment = coin_experiment();
  RunResults results = coin_results(experiment);
  const std::string html = report_html(experiment, results, "results/coin");
  for (auto& [key, trial] : results.trials) trial.wall_time = 77.0;
  EXPECT_EQ(report_html(experiment, results, "results/coin"), html);
}

TEST(Report, EveryFailedTrialHasItsCommand) {
  const Experiment experiment = coin_experiment();
  const RunResults results = coin_results(experiment);
  const std::string html = report_html(experiment, results, "results/coin");
  std::size_t failures = 0;
  for (const auto& [key, trial] : results.trials) {
    const bool failed = trial.record.outcome != TrialOutcome::kSuccess;
    failures += failed ? 1 : 0;
    const std::string line = "<code>" + reproduce_line("results/coin", key) + "</code>";
    EXPECT_EQ(html.find(line) != std::string::npos, failed) << line;
  }
  EXPECT_GT(failures, 10u);
}

TEST(Report, CommandsSurviveTheShell) {
  EXPECT_EQ(reproduce_line("results/coin", {"rate=0.3,side=heads", 4}),
            "binpick reproduce results/coin --cell rate=0.3,side=heads --trial 4");
  EXPECT_EQ(shell_word("it's $HOME"), "'it'\\''s $HOME'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(ResultSummary, CountsOursAndThePapers) {
  const Experiment experiment = coin_experiment();
  RunResults results = coin_results(experiment);
  results.trials.erase({"rate=0.3,side=heads", 3});
  const ResultSummary summary = summarize(experiment, results.trials);
  EXPECT_FALSE(summary.complete());
  EXPECT_EQ(summary.cells[0].ours.trials, 19);
  EXPECT_EQ(summary.cells[1].ours.trials, 20);
  ASSERT_TRUE(summary.cells[1].paper);
  EXPECT_EQ(summary.cells[1].paper->successes, 3);
  ASSERT_EQ(summary.columns.size(), 2u);
  EXPECT_EQ(summary.columns[1].label, "down");
  ASSERT_TRUE(summary.columns[0].comparison);
  std::int64_t outcomes = 0;
  for (const OutcomeCount& each : summary.outcomes) outcomes += each.count;
  EXPECT_EQ(outcomes, 119);
}

TEST(ResultSummary, PairsTrialsOfTheSameNumber) {
  const Experiment experiment = coin_experiment();
  RunResults results{RunManifest::of(experiment), {}, {}};
  StoredTrial failure;
  failure.record.outcome = TrialOutcome::kDropped;
  results.trials[{"rate=0.3,side=heads", 0}] = {};
  results.trials[{"rate=0.3,side=tails", 0}] = failure;
  results.trials[{"rate=0.9,side=heads", 5}] = failure;
  results.trials[{"rate=0.9,side=tails", 5}] = {};
  results.trials[{"rate=0.9,side=tails", 6}] = {};  // without a partner
  results.trials[{"rate=0.6,side=heads", 1}] = {};
  results.trials[{"rate=0.6,side=tails", 1}] = {};
  const ResultSummary summary = summarize(experiment, results.trials);
  ASSERT_EQ(summary.pairs.size(), 1u);
  EXPECT_EQ(summary.pairs[0].only_first, 1);
  EXPECT_EQ(summary.pairs[0].only_second, 1);
}

TEST(ResultTable, PrintsOneRowPerCellWithColumnsSideBySide) {
  const Experiment experiment = coin_experiment();
  const RunResults results = coin_results(experiment);
  const std::string table = result_table(experiment, summarize(experiment, results.trials));
  EXPECT_THAT(table, HasSubstr("side up"));
  EXPECT_THAT(table, HasSubstr("side down"));
  EXPECT_THAT(table, HasSubstr("9/10   90"));
  EXPECT_THAT(table, HasSubstr("failed_grasp   carry"));
}

}  // namespace
}  // namespace binpick
