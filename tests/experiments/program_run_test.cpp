#include "program_run.h"

#include "experiments/sqlite_database.h"

namespace binpick {
namespace {

using testing::HasSubstr;
using testing::Not;

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
  ASSERT_EQ(run_into("four", {"--workers", "4"}), 0);
  EXPECT_TRUE(canonical("one") == canonical("two"));
  EXPECT_TRUE(canonical("one") == canonical("four"));
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

TEST_F(ProgramRun, ShardsInOneFolderCanBeExtendedOneByOne) {
  configure("rate: 0.6");
  for (const char* shard : {"0/2", "1/2"}) {
    ASSERT_EQ(run_into("parts", {"--shard", shard, "--trials", "7"}), 0) << err_;
  }
  for (const char* shard : {"0/2", "1/2"}) {
    ASSERT_EQ(run_into("parts", {"--shard", shard}), 0) << err_;
  }
  ASSERT_EQ(run_into("whole"), 0);
  EXPECT_TRUE(canonical("parts") == canonical("whole"));
}

TEST_F(ProgramRun, VersionsAreNotMixed) {
  configure("rate: 0.6");
  ASSERT_EQ(run_into("a", {"--shard", "0/2"}), 0);
  ASSERT_EQ(run_into("b", {"--shard", "1/2"}), 0);
  const auto change = [&](const std::string& key, const std::string& value) {
    SqliteDatabase store(folder_ / "b" / "trials-1-of-2.sqlite", SqliteDatabase::Access::kWrite);
    store.execute("UPDATE manifest SET value = '" + value + "' WHERE key = '" + key + "'");
  };
  const std::pair<const char*, const char*> changes[] = {
      {"build", "holds results of another build of binpick"},
      {"program", "holds results of binpick 0.0.9, not"},
      {"protocol", "holds results of protocol version 0.0.9, not"},
      {"schema", "a result store of schema '0.0.9', this program reads"}};
  for (const auto& [key, words] : changes) {
    change(key, "0.0.9");
    EXPECT_EQ(run({"merge", "ab", "a", "b"}), 2) << key;
    EXPECT_THAT(err_, HasSubstr(words));
    EXPECT_EQ(run_into("b"), 2) << key;
    EXPECT_THAT(err_, HasSubstr(words));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "ab"));
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
