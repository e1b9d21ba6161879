#include "experiments/report_replays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "coin_experiment.h"
#include "experiments/base64.h"
#include "models/errors.h"
#include "program_run.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kRoomy = 1'000'000;

std::string base64_of_text(const std::string& text) {
  return base64(std::as_bytes(std::span(text)));
}

TEST(Base64, EncodesTheExamplesOfRfc4648) {
  EXPECT_EQ(base64_of_text(""), "");
  EXPECT_EQ(base64_of_text("f"), "Zg==");
  EXPECT_EQ(base64_of_text("fo"), "Zm8=");
  EXPECT_EQ(base64_of_text("foo"), "Zm9v");
  EXPECT_EQ(base64_of_text("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of(std::vector<std::int16_t>{-1, 256}), "//8AAQ==");
}

/// Results of a coin experiment in which trials 1 and 3 of each cell failed, and traces of some.
class Traces : public testing::Test {
 protected:
  Traces() {
    for (const Cell& cell : experiment_.cells()) {
      for (std::int64_t trial = 0; trial < 4; ++trial) {
        StoredTrial stored;
        if (trial % 2 == 1) stored.record.outcome = TrialOutcome::kDropped;
        results_.trials[{cell.key, trial}] = stored;
      }
    }
  }

  void trace(const TrialKey& key, const std::string& scene = "[]") {
    const std::string folder = trace_folder(key).string();
    folder_.write(folder + "/replay.json", "{\"format\":1,\"scene\":" + scene + ",\"frames\":7}");
    folder_.write(folder + "/trace.csv", "time_s\n");
    folder_.write(folder + "/01_bottle_held_2.50s.png", "picture");
    sign_trace(folder_.path() / folder, results_.manifest, results_.trials.at(key).record);
  }

  [[nodiscard]] TraceSection section(const std::string& script, std::size_t most = kRoomy) const {
    return trace_section(folder_.path(), results_, find_traces(folder_.path(), results_), script,
                         most);
  }

  TemporaryFolder folder_;
  Experiment experiment_ = coin_experiment();
  RunResults results_{RunManifest::of(experiment_), {}, {}};
  const TrialKey failed_{"rate=0.3,side=heads", 1};
  const TrialKey fine_{"rate=0.3,side=heads", 0};
};

TEST_F(Traces, FailedTrialsComeFirstAndCellsTakeTurns) {
  const std::vector<TrialKey> keys = trials_to_trace(experiment_, results_.trials, 13);
  ASSERT_EQ(keys.size(), 13u);
  EXPECT_EQ(keys[0], (TrialKey{"rate=0.3,side=heads", 1}));
  EXPECT_EQ(keys[1], (TrialKey{"rate=0.3,side=tails", 1}));
  EXPECT_EQ(keys[6], (TrialKey{"rate=0.3,side=heads", 3}));
  EXPECT_EQ(keys[12], (TrialKey{"rate=0.3,side=heads", 0}));
  EXPECT_TRUE(trials_to_trace(experiment_, results_.trials, 0).empty());
}

TEST_F(Traces, TrialsThatCrashedAreNotRunAgain) {
  for (auto& [key, trial] : results_.trials) trial.record.outcome = TrialOutcome::kCrashed;
  EXPECT_TRUE(trials_to_trace(experiment_, results_.trials, 10).empty());
}

TEST_F(Traces, OnesOfAnotherRunOrAnotherEndDoNotCount) {
  trace(failed_);
  EXPECT_EQ(find_traces(folder_.path(), results_).size(), 1u);
  RunResults other = results_;
  other.manifest.identity = "another seed";
  EXPECT_TRUE(find_traces(folder_.path(), other).empty());
  other = results_;
  other.trials[failed_].record.outcome = TrialOutcome::kSlipped;
  EXPECT_TRUE(find_traces(folder_.path(), other).empty());
}

TEST_F(Traces, AnUnfinishedTraceDoesNotCount) {
  trace(failed_);
  std::filesystem::remove(folder_.path() / trace_folder(failed_) / "trial.json");
  EXPECT_TRUE(find_traces(folder_.path(), results_).empty());
  folder_.write((trace_folder(failed_) / "trial.json").string(), "{\"identity\":");
  EXPECT_TRUE(find_traces(folder_.path(), results_).empty());
}

TEST_F(Traces, FolderNamesHoldNoSeparators) {
  EXPECT_EQ(trace_folder({"file=../a b,x=1.5", 12}), "traces/file=.._a_b,x=1.5_12");
}

TEST_F(Traces, ThePageShowsPicturesFilesAndCommand) {
  trace(failed_);
  const TraceSection shown = section("");
  EXPECT_THAT(shown.html, HasSubstr("base64," + base64_of_text("picture")));
  EXPECT_THAT(shown.html, HasSubstr("<figcaption>bottle held 2.50s</figcaption>"));
  EXPECT_THAT(shown.html, HasSubstr("/trace.csv\">trace.csv</a>"));
  EXPECT_THAT(shown.html, HasSubstr("--cell rate=0.3,side=heads --trial 1"));
  EXPECT_EQ(shown.anchors.at(failed_), "trial-0");
}

TEST_F(Traces, WithoutTheScriptThePageSaysWhatIsMissing) {
  trace(failed_);
  EXPECT_THAT(section("").html, HasSubstr("Install npm"));
  EXPECT_THAT(section("").html, Not(HasSubstr("<script")));
  EXPECT_THAT(section("run()").html, Not(HasSubstr("Install npm")));
}

TEST_F(Traces, WithoutTracesThePageSaysHowToGetThem) {
  EXPECT_THAT(section("run()").html, HasSubstr("binpick report"));
  EXPECT_THAT(section("run()").html, Not(HasSubstr("<script")));
}

TEST_F(Traces, SceneIsEmbeddedOnceAndFailuresComeFirst) {
  trace(fine_, "[\"same\"]");
  trace(failed_, "[\"same\"]");
  trace({"rate=0.9,side=tails", 2}, "[\"other\"]");
  const std::string html = section("run()").html;
  const auto count = [&](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = html.find(text); at != std::string::npos; at = html.find(text, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(count("[\"same\"]"), 1u);
  EXPECT_EQ(count("[\"other\"]"), 1u);
  EXPECT_EQ(count("\"frames\":7"), 3u);
  const std::string opening = "id=\"replay-index\">";
  const std::size_t start = html.find(opening) + opening.size();
  const auto index =
      nlohmann::json::parse(html.substr(start, html.find("</script>", start) - start));
  ASSERT_EQ(index.size(), 3u);
  EXPECT_THAT(index[0]["label"].get<std::string>(), HasSubstr("trial 1: dropped"));
  EXPECT_EQ(index[0]["scene"], index[1]["scene"]);
  EXPECT_NE(index[0]["scene"], index[2]["scene"]);
}

TEST_F(Traces, DataCannotEndItsElement) {
  trace(failed_, "[\"</script><b>\"]");
  const std::string html = section("run()").html;
  EXPECT_THAT(html, Not(HasSubstr("</script><b>")));
  EXPECT_THAT(html, HasSubstr("\\u003c/script>\\u003cb>"));
}

TEST_F(Traces, WhatDoesNotFitStaysOutsideAndIsCounted) {
  trace(failed_);
  trace(fine_);
  const TraceSection shown = section("run()", 40);
  EXPECT_THAT(shown.html, HasSubstr("stayed outside"));
  EXPECT_EQ(shown.anchors.size(), 2u);
  EXPECT_THAT(section("run()").html, Not(HasSubstr("stayed outside")));
}

TEST_F(Traces, ABrokenReplayIsNamed) {
  trace(failed_);
  folder_.write((trace_folder(failed_) / "replay.json").string(), "[1");
  EXPECT_THROW((void)section("run()"), InputError);
}

TEST_F(ProgramRun, AReportRunsFailedTrialsAgainOnce) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out"), 0) << err_;
  ASSERT_EQ(run({"report", "out", "--replays", "3"}), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("running 3 trials again"));
  const std::string html = read_whole_file(folder_ / "out" / "report.html");
  EXPECT_THAT(html, HasSubstr("<article id=\"trial-2\">"));
  EXPECT_THAT(html, Not(HasSubstr("<article id=\"trial-3\">")));
  ASSERT_EQ(run({"report", "out", "--replays", "3"}), 0) << err_;
  EXPECT_THAT(err_, Not(HasSubstr("again")));
  EXPECT_TRUE(read_whole_file(folder_ / "out" / "report.html") == html);
}

TEST_F(ProgramRun, AViewIsAPageOfOneTrial) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out", {"--trials", "3"}), 0) << err_;
  const auto view_trial = [&](const std::string& trial) {
    std::vector<std::string> arguments{"view",    "out", "--cell", "rate=0.3,side=tails",
                                       "--trial", trial};
    ChildOptions no_display;
    no_display.environment = {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}};
    return run(arguments, no_display);
  };
  ASSERT_EQ(view_trial("2"), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("no display here"));
  const std::string html = read_whole_file(folder_ / "out" / "view_rate=0.3,side=tails_2.html");
  EXPECT_THAT(html, HasSubstr("<h3>rate=0.3,side=tails, trial 2: "));
  EXPECT_THAT(html, Not(HasSubstr("<article id=\"trial-1\">")));
  EXPECT_EQ(view_trial("3"), 2);
  EXPECT_THAT(err_, HasSubstr("no trial 3 of cell rate=0.3,side=tails here"));
}

TEST_F(ProgramRun, AReportWithoutReplaysRunsNothing) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out"), 0) << err_;
  ASSERT_EQ(run({"report", "out", "--replays", "0"}), 0) << err_;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "traces"));
}

}  // namespace
}  // namespace binpick
