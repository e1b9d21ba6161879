#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "child_process.h"
#include "coin_experiment.h"
#include "experiments/result_folder.h"
#include "models/random.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Runs the coin program on a configuration in a folder of its own.
class ProgramRun : public testing::Test {
 protected:
  /// The coin experiment with `parameters` in place of its own.
  void configure(const std::string& parameters, const std::string& time_limit = "20") {
    std::string yaml = kCoinYaml;
    const auto replace = [&](const std::string& what, const std::string& by) {
      yaml.replace(yaml.find(what), what.size(), by);
    };
    replace("rate: 0.6, work_ms: 0", parameters);
    replace("time_limit_s: 20", "time_limit_s: " + time_limit);
    folder_.write("coin.yaml", yaml);
  }

  [[nodiscard]] std::unique_ptr<ChildProcess> start(std::vector<std::string> arguments,
                                                    ChildOptions options = {}) const {
    arguments.insert(arguments.begin(), COIN_PROGRAM);
    options.directory = folder_.path();
    return std::make_unique<ChildProcess>(arguments, options);
  }

  int run(const std::vector<std::string>& arguments, const ChildOptions& options = {}) {
    const auto process = start(arguments, options);
    const int code = process->wait();
    out_ = process->out();
    err_ = process->err();
    return code;
  }

  int run_into(const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"run", "coin.yaml", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  /// The canonical bytes of a results folder.
  [[nodiscard]] std::string canonical(const std::string& out) const {
    const std::string json = read_whole_file(folder_ / out / "trials.json");
    EXPECT_THAT(json, HasSubstr("rate=0.9,side=tails"));
    return json + read_whole_file(folder_ / out / "trials.csv");
  }

  [[nodiscard]] nlohmann::json status_of(const std::string& out) {
    EXPECT_EQ(run({"status", out, "--json"}), 0) << err_;
    return nlohmann::json::parse(out_);
  }

  /// Waits until a run has written this many trials; false when that takes too long.
  [[nodiscard]] bool wait_for_trials(const std::string& out, std::int64_t count) {
    const ResultFolder folder(folder_ / out);
    for (int i = 0; i < 2000; ++i) {
      if (!folder.stores().empty() && std::ssize(folder.read().trials) >= count) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  /// Waits until the process has a worker; false when it ended before.
  static bool wait_for_worker(const ChildProcess& process) {
    for (int i = 0; i < 500; ++i) {
      if (!process.children().empty()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  TemporaryFolder folder_;
  std::string out_;
  std::string err_;
};

TEST_F(ProgramRun, PrintsTheTableBesideThePapers) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out"), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("side up"));
  EXPECT_THAT(out_, HasSubstr("side down"));
  EXPECT_THAT(out_, HasSubstr("3/10"));
  EXPECT_THAT(out_, HasSubstr("McNemar"));
  for (const char* name : {"report.html", "trials.csv", "trials.json", "config.yaml"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / name)) << name;
  }
}

TEST_F(ProgramRun, TheNumberOfWorkersDoesNotMatter) {
  configure("rate: 0.6, work_ms: 1");
  ASSERT_EQ(run_into("one", {"--workers", "1"}), 0);
  ASSERT_EQ(run_into("two", {"--workers", "2"}), 0);
  ASSERT_EQ(run_into("five", {"--workers", "5"}), 0);
  EXPECT_TRUE(canonical("one") == canonical("two"));
  EXPECT_TRUE(canonical("one") == canonical("five"));
}

TEST_F(ProgramRun, RunningAgainDoesNothingTwice) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out"), 0);
  const std::string before = canonical("out");
  ASSERT_EQ(run_into("out"), 0);
  EXPECT_THAT(err_, HasSubstr("nothing left to do"));
  EXPECT_TRUE(canonical("out") == before);
}

TEST_F(ProgramRun, MoreTrialsExtendARun) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("grown", {"--trials", "5"}), 0);
  ASSERT_EQ(run_into("grown"), 0);
  EXPECT_THAT(err_, HasSubstr("30 of 120 trials are done already"));
  ASSERT_EQ(run_into("whole"), 0);
  EXPECT_TRUE(canonical("grown") == canonical("whole"));
}

TEST_F(ProgramRun, SettingsMayStandBeforeTheConfiguration) {
  configure("rate: 0.6");
  ASSERT_EQ(run({"run", "--set", "trials=2", "--set", "seed=9", "coin.yaml", "--out", "out"}), 0)
      << err_;
  const std::string config = read_whole_file(folder_ / "out" / "config.yaml");
  EXPECT_THAT(config, HasSubstr("trials: 2"));
  EXPECT_THAT(config, HasSubstr("seed: 9"));
}

TEST_F(ProgramRun, TheDefaultFolderIsKeyedByTheConfiguration) {
  configure("rate: 0.6");
  ASSERT_EQ(run({"run", "coin.yaml"}), 0);
  ASSERT_EQ(run({"run", "coin.yaml"}), 0);
  EXPECT_THAT(err_, HasSubstr("nothing left to do"));
  ASSERT_EQ(run({"run", "coin.yaml", "--seed", "4"}), 0);
  EXPECT_THAT(err_, Not(HasSubstr("nothing left to do")));
}

TEST_F(ProgramRun, ShardsMergeToTheWholeInAnyOrder) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("whole"), 0);
  for (const int count : {1, 2, 5}) {
    std::vector<std::string> merge{"merge", "merged" + std::to_string(count)};
    for (int i = 0; i < count; ++i) {
      const std::string part = "part" + std::to_string(count) + std::to_string(i);
      ASSERT_EQ(run_into(part, {"--shard", std::to_string(i) + "/" + std::to_string(count)}), 0);
      merge.insert(merge.begin() + 2, part);  // backwards
    }
    ASSERT_EQ(run(merge), 0) << err_;
    EXPECT_TRUE(canonical(merge[1]) == canonical("whole"));
  }
  // Twice the same shard, and shards of another partition, change nothing.
  ASSERT_EQ(run({"merge", "merged2", "part20", "part20", "part53"}), 0);
  EXPECT_TRUE(canonical("merged2") == canonical("whole"));
}

TEST_F(ProgramRun, ShardsShareAFolderAndComeFromSlurm) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("whole"), 0);
  for (const char* task : {"1", "2", "3"}) {
    ChildOptions options;
    options.environment = {{"SLURM_ARRAY_TASK_ID", task},
                           {"SLURM_ARRAY_TASK_MIN", "1"},
                           {"SLURM_ARRAY_TASK_COUNT", "3"}};
    ASSERT_EQ(run({"run", "coin.yaml", "--out", "array"}, options), 0) << err_;
  }
  EXPECT_TRUE(canonical("array") == canonical("whole"));
}

TEST_F(ProgramRun, MergeRefusesOtherRuns) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("a", {"--trials", "3"}), 0);
  ASSERT_EQ(run_into("b", {"--trials", "3", "--seed", "4"}), 0);
  EXPECT_EQ(run({"merge", "ab", "a", "b"}), 2);
  EXPECT_THAT(err_, HasSubstr("'seed: 4' instead of 'seed: 3'"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "ab"));
  EXPECT_EQ(run({"merge", "ab", "a", "nowhere"}), 2);
  EXPECT_EQ(run_into("a", {"--trials", "3", "--seed", "4"}), 2);
  EXPECT_THAT(err_, HasSubstr("'seed: 3' instead of 'seed: 4'"));
}

TEST_F(ProgramRun, MergeSaysWhichShardsAreMissing) {
  configure("rate: 0.6");
  for (const char* shard : {"0/5", "2/5"}) ASSERT_EQ(run_into("parts", {"--shard", shard}), 0);
  ASSERT_EQ(run({"merge", "merged", "parts"}), 0);
  EXPECT_THAT(err_, HasSubstr("48 trials of 2 stores"));
  EXPECT_THAT(err_, HasSubstr("no store of shards 1, 3, 4 of 5"));
  EXPECT_THAT(out_, HasSubstr("48 of 120 trials are there"));
  ASSERT_EQ(run({"status", "parts"}), 0);
  EXPECT_THAT(out_, HasSubstr("48 of 120 trials, stopped"));
  EXPECT_THAT(out_, HasSubstr("trials-2-of-5.sqlite: 24 of 24, complete"));
  EXPECT_THAT(out_, HasSubstr("without a store: shards 1, 3, 4 of 5"));
}

TEST_F(ProgramRun, ACrashIsThatTrialsOutcome) {
  configure("rate: 0.6, fault: abort, fault_period: 7");
  ASSERT_EQ(run_into("out"), 0) << err_;
  const std::string csv = read_whole_file(folder_ / "out" / "trials.csv");
  EXPECT_THAT(csv, HasSubstr(",6,crashed,grasp,the process ended by signal 6 (SIGABRT)"));
  EXPECT_THAT(csv, HasSubstr(",13,crashed,grasp"));
  EXPECT_THAT(csv, Not(HasSubstr(",5,crashed")));
  ASSERT_EQ(run_into("again", {"--workers", "1"}), 0);
  EXPECT_TRUE(canonical("out") == canonical("again"));
}

TEST_F(ProgramRun, AHangIsThatTrialsOutcome) {
  configure("rate: 0.6, fault: hang, fault_period: 10", "0.2");
  ASSERT_EQ(run_into("out"), 0) << err_;
  EXPECT_THAT(read_whole_file(folder_ / "out" / "trials.csv"),
              HasSubstr(",9,timeout,grasp,no result within 0.2 s"));
}

TEST_F(ProgramRun, AnExceptionIsThatTrialsOutcome) {
  configure("rate: 0.6, fault: throw, fault_period: 10");
  ASSERT_EQ(run_into("out"), 0) << err_;
  EXPECT_THAT(read_whole_file(folder_ / "out" / "trials.csv"),
              HasSubstr(",9,crashed,grasp,threw: the coin rolled away"));
}

TEST_F(ProgramRun, WhatATrialPrintsDoesNotDisturb) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("quiet"), 0);
  configure("rate: 0.6, fault: print");
  ASSERT_EQ(run_into("loud"), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("a line on stdout that is no reply"));
  EXPECT_TRUE(read_whole_file(folder_ / "loud" / "trials.csv") ==
              read_whole_file(folder_ / "quiet" / "trials.csv"));
}

TEST_F(ProgramRun, LeavesNoFileOutsideTheFolder) {
  configure("rate: 0.6, fault: drop_file");
  ASSERT_EQ(run_into("out"), 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "DROPPED.TXT"));
  std::size_t entries = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    (void)entry;
    ++entries;
  }
  EXPECT_EQ(entries, 2u);  // coin.yaml and out
}

TEST_F(ProgramRun, KillingTheParentLosesNothing) {
  configure("rate: 0.6, work_ms: 4");
  ASSERT_EQ(run_into("whole"), 0);
  Random random(20);
  int kills = 0;
  for (int cycle = 0; cycle < 60; ++cycle) {
    const auto process = start({"run", "coin.yaml", "--out", "killed"});
    std::vector<pid_t> workers;
    if (wait_for_worker(*process)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20 + random.index(60)));
      workers = process->children();
    }
    process->send(SIGKILL);
    const int code = process->wait();
    if (code == 0) break;
    ++kills;
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    for (const pid_t worker : workers) EXPECT_FALSE(alive(worker));
  }
  EXPECT_GE(kills, 2);
  ASSERT_EQ(run_into("killed"), 0) << err_;
  EXPECT_TRUE(canonical("killed") == canonical("whole"));
}

TEST_F(ProgramRun, KillingWorkersLosesNothing) {
  configure("rate: 0.6, work_ms: 10");
  ASSERT_EQ(run_into("whole"), 0);
  const auto process = start({"run", "coin.yaml", "--out", "killed", "--workers", "2"});
  ASSERT_TRUE(wait_for_worker(*process));
  for (int i = 0; i < 4; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(70));
    const auto workers = process->children();
    if (!workers.empty()) ::kill(workers.front(), SIGKILL);
  }
  ASSERT_EQ(process->wait(), 0) << process->err();
  EXPECT_TRUE(canonical("killed") == canonical("whole"));
}

TEST_F(ProgramRun, SignalsEndARunThatCanGoOn) {
  configure("rate: 0.6, work_ms: 5");
  ASSERT_EQ(run_into("whole"), 0);
  for (const auto& [signal, code] : {std::pair{SIGINT, 130}, std::pair{SIGTERM, 143}}) {
    const auto process = start({"run", "coin.yaml", "--out", "stopped"});
    ASSERT_TRUE(wait_for_worker(*process));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto workers = process->children();
    process->send(signal);
    EXPECT_EQ(process->wait(), code);
    for (const pid_t worker : workers) EXPECT_FALSE(alive(worker));
  }
  EXPECT_EQ(run({"status", "stopped"}), 0);
  EXPECT_THAT(out_, HasSubstr("stopped"));
  ASSERT_EQ(run_into("stopped"), 0);
  EXPECT_THAT(err_, HasSubstr("are done already"));
  EXPECT_TRUE(canonical("stopped") == canonical("whole"));
}

TEST_F(ProgramRun, TwoRunsDoNotShareAFolder) {
  configure("rate: 0.6, work_ms: 20");
  const auto first = start({"run", "coin.yaml", "--out", "out"});
  ASSERT_TRUE(wait_for_trials("out", 5));
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("another run (process " + std::to_string(first->pid())));
  EXPECT_EQ(first->wait(), 0);
}

TEST_F(ProgramRun, StatusTellsHowFarARunIs) {
  configure("rate: 0.6, work_ms: 20");
  const auto process = start({"run", "coin.yaml", "--out", "out", "--workers", "2"});
  ASSERT_TRUE(wait_for_trials("out", 10));
  nlohmann::json status = status_of("out");
  EXPECT_EQ(status["state"], "running");
  EXPECT_EQ(status["expected"], 120);
  EXPECT_EQ(status["parts"][0]["process"], process->pid());
  EXPECT_EQ(status["parts"][0]["workers"], 2);
  const double done = status["done"];
  const double mean = double(status["work_time_s"]) / done;
  EXPECT_GE(mean, 0.02);
  EXPECT_NEAR(status["time_left_s"], (120.0 - done) * mean / 2.0, 1e-6);
  process->send(SIGKILL);
  process->wait();
  status = status_of("out");
  EXPECT_EQ(status["state"], "stopped");
  EXPECT_TRUE(status["time_left_s"].is_null());
  ASSERT_EQ(run_into("out"), 0);
  status = status_of("out");
  EXPECT_EQ(status["state"], "complete");
  EXPECT_EQ(status["cells"].size(), 6u);
}

TEST_F(ProgramRun, APausedRunLosesNoTrialToItsTimeLimit) {
  configure("rate: 0.6, work_ms: 200", "1.5");
  const auto process = start({"run", "coin.yaml", "--out", "out", "--trials", "2"});
  ASSERT_TRUE(wait_for_trials("out", 1));
  std::vector<pid_t> all = process->children();
  all.push_back(process->pid());
  for (const pid_t each : all) ::kill(each, SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  for (const pid_t each : all) ::kill(each, SIGCONT);
  ASSERT_EQ(process->wait(), 0) << process->err();
  EXPECT_THAT(read_whole_file(folder_ / "out" / "trials.csv"), Not(HasSubstr("timeout")));
}

TEST_F(ProgramRun, StopsWhereTheIntervalIsNarrowWhateverTheWorkers) {
  configure("rate: 0.6");
  const std::vector<std::string> rule{"--trials", "100", "--set",
                                      "stopping={half_width: 0.12, block: 10}"};
  const auto run_with = [&](const std::string& out, const char* workers) {
    std::vector<std::string> arguments = rule;
    arguments.insert(arguments.end(), {"--workers", workers});
    return run_into(out, arguments);
  };
  for (const char* workers : {"1", "2", "4"}) ASSERT_EQ(run_with(workers, workers), 0) << err_;
  EXPECT_TRUE(canonical("1") == canonical("2"));
  EXPECT_TRUE(canonical("1") == canonical("4"));
  const nlohmann::json status = status_of("1");
  EXPECT_EQ(status["state"], "complete");
  EXPECT_LT(status["done"], 600);
  EXPECT_EQ(status["done"], status["expected"]);
  for (const nlohmann::json& cell : status["cells"]) {
    const double width = double(cell["interval_high"]) - double(cell["interval_low"]);
    EXPECT_TRUE(width <= 0.24 || cell["trials"] == 100) << cell;
  }
  // A run that is interrupted, and a folder that holds more, end in the same results.
  ASSERT_EQ(run_into("grown", {"--trials", "35"}), 0);
  ASSERT_EQ(run_with("grown", "2"), 0) << err_;
  EXPECT_TRUE(canonical("grown") == canonical("1"));
}

TEST_F(ProgramRun, StoppingRulesAndShardsExcludeEachOther) {
  configure("rate: 0.6");
  const std::string rule = "stopping={half_width: 0.12, block: 10}";
  EXPECT_EQ(run_into("out", {"--set", rule, "--shard", "0/2"}), 2);
  EXPECT_THAT(err_, HasSubstr("shards do not go with 'stopping'"));
  ChildOptions options;
  options.environment = {{"SLURM_ARRAY_TASK_ID", "0"}, {"SLURM_ARRAY_TASK_COUNT", "2"}};
  EXPECT_EQ(run({"run", "coin.yaml", "--out", "out", "--set", rule}, options), 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(ProgramRun, AFullDiskKeepsWhatWasWritten) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("whole", {"--trials", "60"}), 0);
  ChildOptions options;
  options.file_size_limit = 30'000;
  EXPECT_EQ(run({"run", "coin.yaml", "--out", "full", "--trials", "60"}, options), 3);
  EXPECT_THAT(err_, HasSubstr("trials.sqlite"));
  ASSERT_EQ(run({"status", "full"}), 0);
  ASSERT_EQ(run_into("full", {"--trials", "60"}), 0);
  EXPECT_THAT(err_, HasSubstr("are done already"));
  EXPECT_TRUE(canonical("full") == canonical("whole"));
}

TEST_F(ProgramRun, AnOlderConfigurationIsRefused) {
  std::string yaml = kCoinYaml;
  folder_.write("old.yaml", "format: 0\n" + yaml);
  EXPECT_EQ(run({"run", "old.yaml", "--out", "out"}), 2);
  EXPECT_THAT(err_, HasSubstr("old.yaml:1:9: a file of format 0, this program reads format 1"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(ProgramRun, AReadOnlyFolderIsAnIoErrorAndCanStillBeLookedAt) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out", {"--trials", "5"}), 0);
  const std::string before = canonical("out");
  constexpr std::filesystem::perms kReadOnly{0555};
  constexpr std::filesystem::perms kWritable{0755};
  ChildOptions options;
  options.unprivileged = true;
  for (const char* each : {"out", "."}) std::filesystem::permissions(folder_ / each, kReadOnly);
  ASSERT_EQ(run({"status", "out"}, options), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("30 of 30 trials"));
  EXPECT_EQ(run({"run", "coin.yaml", "--out", "out", "--trials", "6"}, options), 3);
  EXPECT_THAT(err_, HasSubstr("cannot be written"));
  EXPECT_EQ(run({"run", "coin.yaml", "--out", "other"}, options), 3);
  EXPECT_EQ(run({"merge", "merged", "out"}, options), 3);
  EXPECT_EQ(run({"report", "out"}, options), 3);
  for (const char* each : {".", "out"}) std::filesystem::permissions(folder_ / each, kWritable);
  EXPECT_TRUE(canonical("out") == before);
}

TEST_F(ProgramRun, UnwritableFoldersAreIoErrors) {
  configure("rate: 0.6");
  folder_.write("file", "in the way");
  EXPECT_EQ(run_into("file"), 3);
  EXPECT_EQ(run_into("file/below"), 3);
  EXPECT_EQ(run_into("/proc/results"), 3);
  EXPECT_EQ(read_whole_file(folder_ / "file"), "in the way");
}

TEST_F(ProgramRun, BadInputIsSaidOnceAndNothingIsWritten) {
  configure("rate: 1.6, speed: 1");
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("coin.yaml:7:"));
  configure("rate: 0.6, input: missing.yaml");
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("missing.yaml"));
  // Found by a worker only, while it loads.
  configure("rate: 0.6, input: loaded_late");
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("loaded_late:1:1: no such file"));
  EXPECT_EQ(run({"run", "nowhere.yaml", "--out", "out"}), 2);
  EXPECT_EQ(run({"run"}), 2);
  EXPECT_EQ(run({"fly"}), 2);
  EXPECT_EQ(run_into("out", {"--workers", "0"}), 2);
  EXPECT_EQ(run_into("out", {"--shard", "2/2"}), 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(ProgramRun, ChangedInputFilesAreNotMixedIn) {
  configure("rate: 0.6, input: scene.txt");
  folder_.write("scene.txt", "one");
  ASSERT_EQ(run_into("out"), 0) << err_;
  folder_.write("scene.txt", "two");
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("other scene or model files"));
  EXPECT_EQ(run_into("out", {"--fresh"}), 0);
}

TEST_F(ProgramRun, ReproduceComparesBitForBit) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("out"), 0);
  EXPECT_EQ(run({"reproduce", "out", "--cell", "rate=0.3,side=tails", "--trial", "11"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("identical"));
  EXPECT_EQ(run({"reproduce", "coin.yaml", "--cell", "rate=0.3,side=tails", "--trial", "11"}), 0);
  EXPECT_EQ(run({"reproduce", "out", "--cell", "rate=0.3", "--trial", "11"}), 2);
  EXPECT_EQ(run({"reproduce", "out", "--cell", "rate=0.3,side=tails", "--trial", "20"}), 2);
}

TEST_F(ProgramRun, ReproduceSeesADifference) {
  configure("rate: 0.6, input: scene.txt");
  folder_.write("scene.txt", "a");
  ASSERT_EQ(run_into("out"), 0);
  // A trial that depends on more than its configuration: here, on a file's size.
  folder_.write("scene.txt", "a longer one");
  EXPECT_EQ(run({"reproduce", "out", "--cell", "rate=0.3,side=tails", "--trial", "11"}), 1);
  EXPECT_THAT(out_, HasSubstr("differs"));
  EXPECT_THAT(err_, HasSubstr("other scene or model files"));
}

TEST_F(ProgramRun, AGateFailsOnTheIntervalOnly) {
  configure("rate: 0.6");
  const std::string gate = "gates=[{cell: {side: heads}, minimum_rate: ";
  EXPECT_EQ(run_into("a", {"--set", gate + "0.62}]"}), 0) << out_;
  EXPECT_THAT(out_, HasSubstr("gate passed"));
  EXPECT_EQ(run_into("b", {"--set", gate + "0.9}]"}), 1);
  EXPECT_THAT(out_, HasSubstr("gate FAILED"));
}

}  // namespace
}  // namespace binpick
