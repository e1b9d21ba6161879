#include "experiments/result_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "coin_experiment.h"
#include "experiments/result_export.h"
#include "experiments/result_folder.h"
#include "models/errors.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

RunManifest manifest() { return RunManifest::of(coin_experiment()); }

StoredTrial trial_with(double toss, double wall_time = 0.1) {
  StoredTrial trial;
  trial.record.measures["own_toss"] = toss;
  trial.wall_time = wall_time;
  return trial;
}

TEST(ResultStore, KeepsTrialsAndManifest) {
  const TemporaryFolder folder;
  const auto file = folder / "trials.sqlite";
  StoredTrial failed = trial_with(1.0 / 3.0);
  failed.record.outcome = TrialOutcome::kDropped;
  failed.record.stage = TrialStage::kCarry;
  failed.record.note = "it's \"gone\"; DROP TABLE trials";
  {
    ResultStore store = ResultStore::open_for_run(file, manifest());
    store.add({"rate=0.3,side=heads", 7}, failed);
    store.add({"rate=0.3,side=heads", 2}, trial_with(0.5));
  }
  ResultStore store = ResultStore::open_to_read(file);
  EXPECT_EQ(store.manifest().entries(), manifest().entries());
  const TrialTable trials = store.trials();
  ASSERT_EQ(trials.size(), 2u);
  EXPECT_TRUE(identical(trials.at({"rate=0.3,side=heads", 7}).record, failed.record));
}

TEST(ResultStore, RemembersEveryHostThatTookPart) {
  const TemporaryFolder folder;
  RunManifest made = manifest();
  for (const char* host : {"node2", "node1", "node2"}) {
    made.host = host;
    (void)ResultStore::open_for_run(folder / "trials-0-of-2.sqlite", made);
  }
  made.host = "node3";
  made.cpu = "cpu from another shop";
  (void)ResultStore::open_for_run(folder / "trials-1-of-2.sqlite", made);
  const RunManifest joined = ResultFolder(folder.path()).read().manifest;
  EXPECT_EQ(joined.host, "node1|node2|node3");
  EXPECT_EQ(joined.cpu, "cpu from another shop|" + cpu_class());
}

TEST(ResultStore, RefusesToCountATrialTwice) {
  const TemporaryFolder folder;
  ResultStore store = ResultStore::open_for_run(folder / "trials.sqlite", manifest());
  store.add({"all", 0}, trial_with(0.5));
  EXPECT_THROW(store.add({"all", 0}, trial_with(0.5)), IoError);
}

TEST(ResultStore, RefusesResultsOfAnotherRun) {
  const TemporaryFolder folder;
  const auto file = folder / "trials.sqlite";
  (void)ResultStore::open_for_run(file, manifest());
  const auto change = [&](auto edit) {
    RunManifest other = manifest();
    edit(other);
    EXPECT_THROW((void)ResultStore::open_for_run(file, other), InputError);
  };
  change([](RunManifest& m) { m.experiment = "dice"; });
  change([](RunManifest& m) { m.identity = "0"; });
  change([](RunManifest& m) { m.inputs = "0"; });
  change([](RunManifest& m) { m.protocol = "2"; });
  change([](RunManifest& m) { m.program = "9.9"; });
  change([](RunManifest& m) { m.build = "0"; });
  RunManifest longer = manifest();
  longer.config = "more trials";
  EXPECT_EQ(ResultStore::open_for_run(file, longer).manifest().config, "more trials");
}

TEST(ResultStore, RefusesWhatIsNoStore) {
  const TemporaryFolder folder;
  EXPECT_THROW((void)ResultStore::open_to_read(folder / "nothing.sqlite"), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "nothing.sqlite"));
  const auto text = folder.write("trials.sqlite", std::string(5000, 'x'));
  EXPECT_THROW((void)ResultStore::open_to_read(text), InputError);
  EXPECT_THROW((void)ResultStore::open_for_run(text, manifest()), InputError);
}

TEST(ResultFolder, JoinsStoresInAnyOrder) {
  const TemporaryFolder folder;
  const auto a = folder / "a.sqlite";
  const auto b = folder / "b.sqlite";
  ResultStore::open_for_run(a, manifest())
      .add_all({{{"rate=0.3,side=heads", 0}, trial_with(0.1, 5.0)},
                {{"rate=0.3,side=heads", 1}, trial_with(0.2)}});
  ResultStore::open_for_run(b, manifest())
      .add_all({{{"rate=0.3,side=heads", 0}, trial_with(0.1, 3.0)},
                {{"rate=0.9,side=tails", 4}, trial_with(0.3)}});
  const RunResults ab = read_results({a, b});
  const RunResults ba = read_results({b, a});
  EXPECT_TRUE(ab.conflicts.empty());
  EXPECT_EQ(ab.trials.size(), 3u);
  EXPECT_EQ(ab.trials.begin()->second.wall_time, ba.trials.begin()->second.wall_time);
  EXPECT_EQ(ab.manifest.entries(), ba.manifest.entries());
  EXPECT_EQ(results_to_json(coin_experiment(), ab), results_to_json(coin_experiment(), ba));
}

TEST(ResultFolder, ReportsTrialsThatDisagree) {
  const TemporaryFolder folder;
  const auto a = folder / "a.sqlite";
  const auto b = folder / "b.sqlite";
  const TrialKey key{"rate=0.3,side=heads", 0};
  ResultStore::open_for_run(a, manifest()).add(key, trial_with(0.1));
  ResultStore::open_for_run(b, manifest()).add(key, trial_with(0.1000000001));
  EXPECT_THAT(read_results({a, b}).conflicts, ElementsAre(key));
}

TEST(ResultFolder, RefusesToJoinDifferentRuns) {
  const TemporaryFolder folder;
  RunManifest other = manifest();
  other.identity = "another seed";
  (void)ResultStore::open_for_run(folder / "a.sqlite", manifest());
  (void)ResultStore::open_for_run(folder / "b.sqlite", other);
  EXPECT_THROW((void)read_results({folder / "a.sqlite", folder / "b.sqlite"}), InputError);
  EXPECT_THROW((void)read_results({}), InputError);
}

TEST(ResultStore, WhatAKillLeftOfAStoreInTheMakingIsNoStore) {
  const TemporaryFolder folder;
  const ResultFolder results(folder.path());
  const std::filesystem::path file = results.store_of(std::nullopt);
  folder.write("trials.sqlite.part", "half a");
  folder.write("trials.sqlite.part-journal", "half a");
  EXPECT_TRUE(results.stores().empty());
  (void)ResultStore::open_for_run(file, manifest());
  EXPECT_EQ(results.read().manifest.entries(), manifest().entries());
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".part"));
}

TEST(ResultFolder, OneRunAtATime) {
  const TemporaryFolder folder;
  const ResultFolder results(folder.path());
  const std::filesystem::path store = results.store_of(std::nullopt);
  EXPECT_FALSE(ResultFolder::writer_of(store));
  {
    const FileDescriptor lock = results.lock(std::nullopt, 3);
    const auto writer = ResultFolder::writer_of(store);
    ASSERT_TRUE(writer);
    EXPECT_EQ(writer->process, ::getpid());
    EXPECT_EQ(writer->workers, 3);
    EXPECT_THROW((void)results.lock(std::nullopt, 1), InputError);
    EXPECT_NO_THROW((void)results.lock(Shard{0, 2}, 1));
  }
  EXPECT_FALSE(ResultFolder::writer_of(store));
}

TEST(ResultFolder, StoresAreNamedAfterTheirShards) {
  const ResultFolder results("folder");
  const auto shard = ResultFolder::shard_of(results.store_of(Shard{3, 8}));
  ASSERT_TRUE(shard);
  EXPECT_EQ(shard->index, 3);
  EXPECT_EQ(shard->count, 8);
  for (const char* name : {"trials.sqlite", "trials-8-of-8.sqlite", "trials-1-of-2.sqlite.old"}) {
    EXPECT_FALSE(ResultFolder::shard_of(name)) << name;
  }
}

TEST(RunManifest, SaysWhatDiffers) {
  const RunManifest ours = manifest();
  const auto conflict_of = [&](const std::string& what, const std::string& by) {
    std::string yaml = kCoinYaml;
    yaml.replace(yaml.find(what), what.size(), by);
    return ours.conflict_with(RunManifest::of(coin_experiment(yaml)));
  };
  EXPECT_EQ(conflict_of("seed: 3", "seed: 4"),
            "results of another configuration ('seed: 4' instead of 'seed: 3')");
  EXPECT_EQ(conflict_of("work_ms: 0", "work_ms: 2"),
            "results of another configuration ('work_ms: 2' instead of 'work_ms: 0')");
  EXPECT_EQ(conflict_of("[0.3, 0.6, 0.9]", "[0.3, 0.6, 0.9, 1]"),
            "results of another configuration ('values: [0.3, 0.6, 0.9, 1]' instead of 'values: "
            "[0.3, 0.6, 0.9]')");
  EXPECT_EQ(conflict_of("trials: 20", "trials: 30"), "");
}

TEST(ResultExport, CsvQuotesWhatNeedsIt) {
  StoredTrial trial = trial_with(0.5);
  trial.record.note = "a \"b\", c";
  RunResults results{manifest(), {{{"rate=0.3,side=heads", 0}, trial}}, {}};
  EXPECT_EQ(results_to_csv(coin_experiment(), results),
            "cell,rate,side,trial,outcome,stage,note,own_toss\n"
            "\"rate=0.3,side=heads\",0.3,heads,0,success,judge,\"a \"\"b\"\", c\",0.5\n");
}

TEST(ResultExport, LeavesOutTimesAndTrialsBeyondTheExperiment) {
  RunResults results{manifest(), {{{"rate=0.3,side=heads", 0}, trial_with(0.5, 1.0)}}, {}};
  const std::string json = results_to_json(coin_experiment(), results);
  results.trials.begin()->second.wall_time = 2.0;
  results.trials[{"rate=0.3,side=heads", 20}] = trial_with(0.5);
  EXPECT_EQ(results_to_json(coin_experiment(), results), json);
}

}  // namespace
}  // namespace binpick
