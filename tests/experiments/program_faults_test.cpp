#include <fmt/format.h>

#include <algorithm>

#include "experiments/sqlite_database.h"
#include "models/random.h"
#include "program_run.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

/// What a run has to stand: trials that misbehave, kills, pauses, full disks, bad input.
class ProgramFaults : public ProgramRun {
 protected:
  /// Processes whose parent was killed are killed by the kernel, in a moment.
  static bool all_end(const std::vector<pid_t>& processes) {
    for (int i = 0; i < 500; ++i) {
      if (std::none_of(processes.begin(), processes.end(), alive)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
};

TEST_F(ProgramFaults, ACrashIsThatTrialsOutcome) {
  configure("rate: 0.6, fault: abort, fault_period: 7");
  ASSERT_EQ(run_into("out"), 0) << err_;
  const std::string csv = read_whole_file(folder_ / "out" / "trials.csv");
  EXPECT_THAT(csv, HasSubstr(",6,crashed,grasp,the process ended by signal 6 (SIGABRT)"));
  EXPECT_THAT(csv, HasSubstr(",13,crashed,grasp"));
  EXPECT_THAT(csv, Not(HasSubstr(",5,crashed")));
  ASSERT_EQ(run_into("again", {"--workers", "1"}), 0);
  EXPECT_TRUE(canonical("out") == canonical("again"));
}

TEST_F(ProgramFaults, AHangIsThatTrialsOutcome) {
  for (const auto& [fault, note] :
       {std::pair{"hang", "no result within 1 s of wall-clock time"},
        std::pair{"spin", "no result within 0.1 s of processor time"}}) {
    configure(fmt::format("rate: 0.6, fault: {}, fault_period: 10", fault), "0.1");
    ASSERT_EQ(run_into(fault, {"--trials", "10"}), 0) << err_;
    const std::string csv = read_whole_file(folder_ / fault / "trials.csv");
    EXPECT_THAT(csv, HasSubstr(std::string(",9,timeout,grasp,") + note));
    EXPECT_THAT(csv, Not(HasSubstr(",8,timeout")));
  }
}

TEST_F(ProgramFaults, ASlowMachineLosesNoTrialToTheTimeLimit) {
  configure("rate: 0.6, work_ms: 100", "1");
  const auto process = start({"run", "coin.yaml", "--out", "out", "--trials", "1"});
  ASSERT_TRUE(wait_for_trials("out", 1));
  // Workers that get no processor for longer than the limit.
  const std::vector<pid_t> workers = process->children();
  for (const pid_t worker : workers) ::kill(worker, SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(2000));
  for (const pid_t worker : workers) ::kill(worker, SIGCONT);
  ASSERT_EQ(process->wait(), 0) << process->err();
  EXPECT_THAT(read_whole_file(folder_ / "out" / "trials.csv"), Not(HasSubstr("timeout")));
}

TEST_F(ProgramFaults, AnExceptionIsThatTrialsOutcome) {
  configure("rate: 0.6, fault: throw, fault_period: 10");
  ASSERT_EQ(run_into("out"), 0) << err_;
  EXPECT_THAT(read_whole_file(folder_ / "out" / "trials.csv"),
              HasSubstr(",9,crashed,grasp,threw: the coin rolled away"));
}

TEST_F(ProgramFaults, WhatATrialPrintsDoesNotDisturb) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("quiet"), 0);
  configure("rate: 0.6, fault: print");
  ASSERT_EQ(run_into("loud"), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("a line on stdout that is no reply"));
  EXPECT_TRUE(read_whole_file(folder_ / "loud" / "trials.csv") ==
              read_whole_file(folder_ / "quiet" / "trials.csv"));
}

TEST_F(ProgramFaults, LeavesNoFileOutsideTheFolder) {
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

// Parents and workers are killed at random moments: while they start, load, run, write and report.
TEST_F(ProgramFaults, AHundredKillsLoseNothingAndCountNothingTwice) {
  configure("rate: 0.6, work_ms: 4");
  const auto start_of_whole = std::chrono::steady_clock::now();
  ASSERT_EQ(run_into("whole"), 0);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start_of_whole;
  Random random(20);
  int kills = 0;
  int runs = 0;
  while (kills < 100) {
    const std::string out = "killed" + std::to_string(runs);
    const auto process = start({"run", "coin.yaml", "--out", out, "--workers", "2"});
    const bool worker_first = random.uniform() < 0.5;
    std::this_thread::sleep_for(random.uniform(0.0, 0.6) * whole);
    std::vector<pid_t> workers = process->children();
    if (worker_first && !workers.empty()) {
      ::kill(workers[random.index(workers.size())], SIGKILL);
      ++kills;
      std::this_thread::sleep_for(random.uniform(0.0, 0.2) * whole);
      workers = process->children();
    }
    process->send(SIGKILL);
    if (process->wait() != 0) {
      ++kills;
      EXPECT_TRUE(all_end(workers));
      continue;
    }
    ++runs;
    ASSERT_TRUE(canonical(out) == canonical("whole")) << out;
  }
  const std::string last = "killed" + std::to_string(runs);
  ASSERT_EQ(run_into(last), 0) << err_;
  EXPECT_TRUE(canonical(last) == canonical("whole"));
  std::printf("%d kills, %d runs finished in between\n", kills, runs);
}

TEST_F(ProgramFaults, SignalsEndARunThatCanGoOn) {
  configure("rate: 0.6, work_ms: 5");
  ASSERT_EQ(run_into("whole"), 0);
  for (const auto& [signal, code] : {std::pair{SIGINT, 130}, std::pair{SIGTERM, 143}}) {
    const auto process = start({"run", "coin.yaml", "--out", "stopped"});
    ASSERT_TRUE(wait_for_worker(*process));
    ASSERT_TRUE(wait_for_trials("stopped", 3));
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

TEST_F(ProgramFaults, TwoRunsDoNotShareAFolder) {
  configure("rate: 0.6, work_ms: 20");
  const auto first = start({"run", "coin.yaml", "--out", "out"});
  ASSERT_TRUE(wait_for_trials("out", 5));
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("another run (process " + std::to_string(first->pid())));
  EXPECT_EQ(first->wait(), 0);
}

TEST_F(ProgramFaults, APausedRunLosesNoTrialToTheTimeLimit) {
  configure("rate: 0.6, work_ms: 100", "0.2");  // 2 s by the wall clock
  const auto process = start({"run", "coin.yaml", "--out", "out", "--trials", "2"});
  ASSERT_TRUE(wait_for_trials("out", 1));
  std::vector<pid_t> all = process->children();
  all.push_back(process->pid());
  for (const pid_t each : all) ::kill(each, SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(3000));
  for (const pid_t each : all) ::kill(each, SIGCONT);
  ASSERT_EQ(process->wait(), 0) << process->err();
  EXPECT_THAT(read_whole_file(folder_ / "out" / "trials.csv"), Not(HasSubstr("timeout")));
}

TEST_F(ProgramFaults, APauseIsTakenOffTheTrialThatItFellInto) {
  configure("rate: 0.6, work_ms: 100");
  const auto process = start({"run", "coin.yaml", "--out", "out", "--trials", "2"});
  ASSERT_TRUE(wait_for_trials("out", 1));
  // The workers finish their trials meanwhile, and get their next ones after the pause.
  ::kill(process->pid(), SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  ::kill(process->pid(), SIGCONT);
  ASSERT_EQ(process->wait(), 0) << process->err();
  SqliteDatabase store(folder_ / "out" / "trials.sqlite", SqliteDatabase::Access::kRead);
  auto shortest = store.prepare("SELECT MIN(wall_time_s) FROM trials");
  ASSERT_TRUE(shortest.step());
  EXPECT_GT(shortest.number(0), 0.0);
}

TEST_F(ProgramFaults, AFullDiskKeepsWhatWasWritten) {
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

// A real full disk, where the kernel lets us make a small one.
TEST_F(ProgramFaults, AFullFileSystemKeepsWhatWasWritten) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("whole", {"--trials", "80"}), 0);
  std::filesystem::create_directory(folder_ / "small");
  folder_.write("script", R"(
    mount -t tmpfs -o size=60k none small || exit 77
    $0 run coin.yaml --out small/full --trials 80; [ $? -eq 3 ] || exit 1
    $0 status small/full || exit 2
    mount -o remount,size=10m small
    $0 run coin.yaml --out small/full --trials 80 || exit 3
    cp -r small/full full)");
  const auto process = std::make_unique<ChildProcess>(
      std::vector<std::string>{"/usr/bin/unshare", "-rm", "sh", "-c", ". ./script", COIN_PROGRAM},
      ChildOptions{.directory = folder_.path(), .environment = {}, .file_size_limit = {}});
  const int code = process->wait();
  if (process->err().find("not permitted") != std::string::npos || code == 127) {
    GTEST_SKIP() << "no mounts here: " << process->err();
  }
  ASSERT_EQ(code, 0) << process->err();
  EXPECT_THAT(process->err(), HasSubstr("no space left"));
  EXPECT_THAT(process->err(), HasSubstr("are done already"));
  EXPECT_TRUE(canonical("full") == canonical("whole"));
}

TEST_F(ProgramFaults, AnOlderConfigurationIsRefused) {
  std::string yaml = kCoinYaml;
  folder_.write("old.yaml", "format: 0\n" + yaml);
  EXPECT_EQ(run({"run", "old.yaml", "--out", "out"}), 2);
  EXPECT_THAT(err_, HasSubstr("old.yaml:1:9: a file of format 0, this program reads format 1"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(ProgramFaults, AReadOnlyFolderIsAnIoErrorAndCanStillBeLookedAt) {
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

TEST_F(ProgramFaults, UnwritableFoldersAreIoErrors) {
  configure("rate: 0.6");
  folder_.write("file", "in the way");
  EXPECT_EQ(run_into("file"), 3);
  EXPECT_EQ(run_into("file/below"), 3);
  EXPECT_EQ(run_into("/proc/results"), 3);
  EXPECT_EQ(read_whole_file(folder_ / "file"), "in the way");
}

TEST_F(ProgramFaults, BadInputIsSaidOnceAndNothingIsWritten) {
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

TEST_F(ProgramFaults, ChangedInputFilesAreNotMixedIn) {
  configure("rate: 0.6, input: scene.txt");
  folder_.write("scene.txt", "one");
  ASSERT_EQ(run_into("out"), 0) << err_;
  folder_.write("scene.txt", "two");
  EXPECT_EQ(run_into("out"), 2);
  EXPECT_THAT(err_, HasSubstr("other scene or model files"));
  EXPECT_EQ(run_into("out", {"--fresh"}), 0);
}

}  // namespace
}  // namespace binpick
