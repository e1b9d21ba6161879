#include "experiments/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "coin_experiment.h"
#include "experiments/shard.h"
#include "models/errors.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using testing::HasSubstr;

/// The message of the InputError that loading `yaml` raises.
std::string problems_of(const std::string& yaml) {
  try {
    (void)coin_experiment(yaml);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

TEST(Experiment, CellsAreTheProductOfTheAxes) {
  const Experiment experiment = coin_experiment();
  ASSERT_EQ(experiment.cells().size(), 6u);
  EXPECT_EQ(experiment.cells()[0].key, "rate=0.3,side=heads");
  EXPECT_EQ(experiment.cells()[1].key, "rate=0.3,side=tails");
  EXPECT_EQ(experiment.cells()[5].key, "rate=0.9,side=tails");
  EXPECT_EQ(experiment.job_count(), 120);
  EXPECT_EQ(experiment.cell("rate=0.6,side=tails").index, 3u);
  EXPECT_THROW((void)experiment.cell("rate=0.7,side=tails"), InputError);
}

TEST(Experiment, WithoutAxesThereIsOneCell) {
  const Experiment experiment = coin_experiment("experiment: one\nkind: coin\n");
  ASSERT_EQ(experiment.cells().size(), 1u);
  EXPECT_EQ(experiment.cells()[0].key, "all");
}

TEST(Experiment, AssignmentReachesTheParameters) {
  const Experiment experiment = coin_experiment();
  const auto kind = experiment.make_kind();
  const auto outcome_in = [&](const std::string& cell) {
    experiment.assign(experiment.cell(cell), *kind);
    int successes = 0;
    for (std::int64_t trial = 0; trial < 300; ++trial) {
      const TrialContext context{experiment.seeds(experiment.cell(cell), trial), trial, {}, {}, {}};
      successes += kind->run(context).outcome == TrialOutcome::kSuccess ? 1 : 0;
    }
    return successes;
  };
  EXPECT_NEAR(outcome_in("rate=0.3,side=heads"), 90, 32);
  EXPECT_NEAR(outcome_in("rate=0.9,side=tails"), 270, 21);
  EXPECT_NEAR(outcome_in("rate=0.6,side=heads"), 180, 34);
}

TEST(Experiment, SharedSeedsLeaveTheCellOut) {
  const Experiment experiment = coin_experiment();
  const auto& cells = experiment.cells();
  EXPECT_EQ(experiment.seeds(cells[0], 4).shared("pile"),
            experiment.seeds(cells[5], 4).shared("pile"));
  std::set<Seed> seeds;
  for (const Cell& cell : cells) {
    for (std::int64_t trial = 0; trial < 20; ++trial) {
      seeds.insert(experiment.seeds(cell, trial).own("pile"));
      seeds.insert(experiment.seeds(cell, trial).own("noise"));
      seeds.insert(experiment.seeds(cell, trial).shared("pile"));
    }
  }
  EXPECT_EQ(seeds.size(), 6u * 20u * 2u + 20u);
}

TEST(Experiment, AllProblemsComeAtOnceWithTheirPlaces) {
  std::string yaml = replaced(kCoinYaml, "trials: 20", "trials: 0");
  yaml = replaced(yaml, "rate: 0.6, work_ms: 0", "rate: 1.5, speed: 3");
  yaml = replaced(yaml, "key: coin.side", "key: coin.edge");
  yaml = replaced(yaml, "{rate: 0.9}", "{rate: 0.8}");
  const std::string problems = problems_of(yaml);
  EXPECT_THAT(problems, HasSubstr("coin.yaml:5:9: 'trials' is 0"));
  EXPECT_THAT(problems, HasSubstr("coin.yaml:7:20: 'parameters.rate' is 1.5"));
  EXPECT_THAT(problems, HasSubstr("unknown key 'parameters.speed'"));
  EXPECT_THAT(problems, HasSubstr("coin.yaml:10:"));
  EXPECT_THAT(problems, HasSubstr("coin.edge"));
  EXPECT_THAT(problems, HasSubstr("'cell' gives 'rate' the value 0.8"));
}

TEST(Experiment, AxisProblemsAreFound) {
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "[0.3, 0.6, 0.9]", "[0.3, 0.6, 9]")),
              HasSubstr("outside [0, 1]"));
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "[heads, tails]", "[heads, heads]")),
              HasSubstr("twice"));
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "name: side", "name: rate")),
              HasSubstr("two axes have this name"));
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "\"up\", \"down\"", "\"up\"")),
              HasSubstr("one entry per value"));
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "kind: coin", "kind: dice")),
              HasSubstr("'kind' must be one of: coin"));
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "successes: 3", "successes: 13")),
              HasSubstr("exceeds"));
  EXPECT_THAT(problems_of(replaced(kCoinYaml, "experiment: coin", "experiment: ../coin")),
              HasSubstr("letters"));
}

TEST(Experiment, OverridesAreCheckedLikeTheFile) {
  const TemporaryFolder folder;
  const auto file = folder.write("coin.yaml", kCoinYaml);
  const auto load = [&](const std::string& setting) {
    return Experiment::load(file, {ConfigOverride::parse(setting)}, coin_registry());
  };
  EXPECT_EQ(load("trials=7").config().trials, 7);
  const auto bare = {ConfigOverride::parse("axes=[]"), ConfigOverride::parse("paper=[]")};
  EXPECT_EQ(Experiment::load(file, bare, coin_registry()).cells().size(), 1u);
  EXPECT_THROW((void)load("axes=[]"), InputError);  // the paper's cells are left over
  EXPECT_THROW((void)load("trials=many"), InputError);
  EXPECT_THROW((void)load("parameters.rat=0.1"), InputError);
  EXPECT_THROW((void)load("parameters.rate=7"), InputError);
  EXPECT_THROW((void)load("parameters.rate"), InputError);
  EXPECT_THROW((void)load("a: b=7"), InputError);
  EXPECT_THROW((void)load("trials=7\nseed: 4"), InputError);
}

TEST(Experiment, TheEffectiveConfigurationReadsBackToItself) {
  const Experiment experiment = coin_experiment();
  const Experiment again = coin_experiment(experiment.effective_yaml());
  EXPECT_EQ(again.effective_yaml(), experiment.effective_yaml());
  EXPECT_EQ(again.config_hash(), experiment.config_hash());
  EXPECT_THAT(experiment.effective_yaml(), HasSubstr("fault: none"));
}

TEST(Experiment, IdentityIsWhatDecidesTheRecords) {
  const Experiment experiment = coin_experiment();
  const Experiment longer = coin_experiment(replaced(kCoinYaml, "trials: 20", "trials: 30"));
  const Experiment other = coin_experiment(replaced(kCoinYaml, "seed: 3", "seed: 4"));
  EXPECT_EQ(longer.identity_hash(), experiment.identity_hash());
  EXPECT_NE(longer.config_hash(), experiment.config_hash());
  EXPECT_NE(other.identity_hash(), experiment.identity_hash());
}

TEST(Shard, EveryJobBelongsToExactlyOneShardAndEveryShardHasEveryCell) {
  const Experiment experiment = coin_experiment();
  for (const std::int64_t count : {1, 2, 5, 7}) {
    for (std::int64_t i = 0; i < experiment.job_count(); ++i) {
      int holders = 0;
      for (std::int64_t index = 0; index < count; ++index) {
        holders += Shard{index, count}.holds(experiment.job(i)) ? 1 : 0;
      }
      EXPECT_EQ(holders, 1);
    }
    std::set<std::size_t> cells;
    for (std::int64_t i = 0; i < experiment.job_count(); ++i) {
      if (Shard{0, count}.holds(experiment.job(i))) cells.insert(experiment.job(i).cell);
    }
    EXPECT_EQ(cells.size(), experiment.cells().size()) << count;
  }
}

TEST(Shard, ParsesNothingButAProperPart) {
  EXPECT_EQ(Shard::parse("3/8").index, 3);
  EXPECT_EQ(Shard::parse("3/8").count, 8);
  for (const char* text : {"", "3", "8/8", "-1/8", "1/0", "a/b", "1/2/3", "1 /2"}) {
    EXPECT_THROW((void)Shard::parse(text), InputError) << text;
  }
}

}  // namespace
}  // namespace binpick
