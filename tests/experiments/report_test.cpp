#include "experiments/report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "coin_experiment.h"
#include "experiments/html.h"
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

std::string page(const Experiment& experiment, const RunResults& results,
                 const std::string& folder = "results/coin") {
  return report_html(experiment, results, summarize(experiment, results.trials), folder);
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
  const std::string html = page(experiment, coin_results(experiment));
  EXPECT_EQ(first_unbalanced_element(html), "");
  EXPECT_THAT(html, Not(HasSubstr("http")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_THAT(html, HasSubstr("<svg"));
}

TEST(Report, SaysWhenTrialsAreMissing) {
  const Experiment experiment = coin_experiment();
  RunResults results = coin_results(experiment);
  EXPECT_THAT(page(experiment, results), Not(HasSubstr("Not finished")));
  results.trials.erase({"rate=0.3,side=heads", 3});
  EXPECT_THAT(page(experiment, results), HasSubstr("Not finished: 1 of 120 trials are missing"));
}

TEST(Report, EscapesEverything) {
  const Experiment experiment = hostile_experiment();
  const std::string html = page(experiment, coin_results(experiment), "a <folder>'s");
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<heads>")));
  EXPECT_THAT(html, Not(HasSubstr("<folder>")));
  EXPECT_THAT(html, HasSubstr("Coins &lt;heads&gt; &amp; tails"));
}

TEST(Report, IsAFunctionOfTheResults) {
  const Experiment experiment = coin_experiment();
  RunResults results = coin_results(experiment);
  const std::string html = page(experiment, results);
  for (auto& [key, trial] : results.trials) trial.wall_time = 77.0;
  EXPECT_EQ(page(experiment, results), html);
}

TEST(Report, EveryFailedTrialHasItsCommand) {
  const Experiment experiment = coin_experiment();
  const RunResults results = coin_results(experiment);
  const std::string html = page(experiment, results);
  std::size_t failures = 0;
  for (const auto& [key, trial] : results.trials) {
    const bool failed = trial.record.outcome != TrialOutcome::kSuccess;
    failures += failed ? 1 : 0;
    const std::string line = "<code>" + reproduce_line("results/coin", key) + "</code>";
    EXPECT_EQ(html.find(line) != std::string::npos, failed) << line;
  }
  EXPECT_GT(failures, 10u);
}

TEST(Report, CellsLeadToTheirFailedTrialsAndThoseToTheirTraces) {
  const Experiment experiment = coin_experiment();
  const RunResults results = coin_results(experiment);
  const ResultSummary summary = summarize(experiment, results.trials);
  TraceSection shown{"<article id=\"trial-0\"></article>", {}};
  const auto failed = std::find_if(
      results.trials.begin(), results.trials.end(),
      [](const auto& each) { return each.second.record.outcome != TrialOutcome::kSuccess; });
  shown.anchors[failed->first] = "trial-0";
  const std::string html = report_html(experiment, results, summary, "results/coin", shown);
  EXPECT_THAT(html, HasSubstr(fmt::format("<a href=\"#trial-0\">{}</a>", failed->first.trial)));
  for (const Cell& cell : experiment.cells()) {
    const bool any = summary.cells[cell.index].ours.rate() < 1.0;
    const std::string id = fmt::format("cell-{}\"", cell.index);
    EXPECT_EQ(html.find("href=\"#" + id) != std::string::npos, any) << id;
    EXPECT_EQ(html.find("id=\"" + id) != std::string::npos, any) << id;
  }
}

TEST(Report, LongTablesAreFoldedAway) {
  EXPECT_THAT(scrolling_table("<tr></tr>", 9), Not(HasSubstr("<details>")));
  EXPECT_THAT(scrolling_table("<tr></tr>", 60), HasSubstr("<summary>60 rows</summary>"));
}

TEST(Report, NumbersHaveNoExponentWhereAPersonReadsThem) {
  EXPECT_EQ(digits_text(361.2, 2), "361");
  EXPECT_EQ(digits_text(75370.0, 4), "75370");
  EXPECT_EQ(digits_text(0.012345, 3), "0.0123");
  EXPECT_EQ(digits_text(-1234.5, 3), "-1234");
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
