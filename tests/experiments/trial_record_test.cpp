#include "experiments/trial_record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "experiments/worker_protocol.h"
#include "models/errors.h"

namespace binpick {
namespace {

TrialRecord awkward_record() {
  TrialRecord record;
  record.outcome = TrialOutcome::kCollisionAbort;
  record.stage = TrialStage::kApproach;
  record.note = "\"quoted\" <b>\\ back, unicode \xC3\xA9, tab\t";
  record.measures = {{"third", 1.0 / 3.0},
                     {"negative_zero", -0.0},
                     {"tiny", std::numeric_limits<double>::denorm_min()},
                     {"huge", std::numeric_limits<double>::max()},
                     {"integer", 9007199254740993.0},
                     {"infinite", -std::numeric_limits<double>::infinity()},
                     {"unknown", std::numeric_limits<double>::quiet_NaN()}};
  return record;
}

TEST(TrialRecord, JsonKeepsEveryBit) {
  const TrialRecord record = awkward_record();
  EXPECT_TRUE(identical(record_from_json(to_json(record)), record)) << to_json(record);
  EXPECT_EQ(to_json(record_from_json(to_json(record))), to_json(record));
}

TEST(TrialRecord, TheWireKeepsEveryBit) {
  WorkerReply reply;
  reply.type = WorkerReply::Type::kRecord;
  reply.record = awkward_record();
  const std::string line = encode(reply);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto decoded = decode_reply(line);
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(identical(decoded->record, reply.record));
}

TEST(TrialRecord, IdenticalSeesEveryDifference) {
  const TrialRecord record = awkward_record();
  TrialRecord other = record;
  other.measures["negative_zero"] = 0.0;
  EXPECT_FALSE(identical(record, other));
  other = record;
  other.measures.erase("tiny");
  EXPECT_FALSE(identical(record, other));
  other = record;
  other.note += ".";
  EXPECT_FALSE(identical(record, other));
  other = record;
  other.stage = TrialStage::kGrasp;
  EXPECT_FALSE(identical(record, other));
}

TEST(TrialRecord, NamesGoBothWays) {
  for (const TrialOutcome outcome : kTrialOutcomes) {
    EXPECT_EQ(outcome_from_text(to_text(outcome)), outcome);
  }
  for (const TrialStage stage : kTrialStages) EXPECT_EQ(stage_from_text(to_text(stage)), stage);
  EXPECT_FALSE(outcome_from_text("Success"));
  EXPECT_FALSE(stage_from_text(""));
}

TEST(TrialRecord, RefusesWhatItDidNotWrite) {
  for (const char* json :
       {"", "{}", "[]", R"({"outcome":"won","stage":"judge","note":""})",
        R"({"outcome":"success","stage":"judge","note":"","measures":{"a":"b"}})"}) {
    EXPECT_THROW((void)record_from_json(json), InputError) << json;
  }
  EXPECT_FALSE(decode_reply("not json"));
  EXPECT_FALSE(decode_reply("{}"));
  EXPECT_FALSE(decode_order(R"({"trial":"x"})"));
}

TEST(TrialRecord, InvalidUtf8InANoteDoesNotHurt) {
  TrialRecord record;
  record.note = "bad \xff byte";
  EXPECT_NO_THROW((void)record_from_json(to_json(record)));
}

}  // namespace
}  // namespace binpick
