#include "experiments/trial_replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "experiments/replay_scene.h"
#include "scenes/scene.h"
#include "sim/physics_draw.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using nlohmann::json;
using testing::ElementsAre;

TEST(ReplayTrack, KeepsAKeyWhereTheSignalChanges) {
  const ReplayTrack track = keys_of({1, {0, 0, 1, 2, 3, 3, 3, 0}}, 1);
  EXPECT_THAT(track.frames, ElementsAre(0, 3, 7));
  EXPECT_THAT(track.values, ElementsAre(0, 2, 0));
}

TEST(ReplayTrack, IsNeverFurtherOffThanItsTolerance) {
  RecordedSignal signal{2, {}};
  for (int i = 0; i < 500; ++i) {
    signal.values.push_back(static_cast<float>(300.0 * std::sin(0.05 * i)));
    signal.values.push_back(static_cast<float>(0.1 * i));
  }
  const ReplayTrack track = keys_of(signal, 4);
  EXPECT_LT(track.frames.size(), 450u);
  std::size_t key = 0;
  for (std::size_t frame = 0; frame < 500; ++frame) {
    while (key + 1 < track.frames.size() && track.frames[key + 1] <= frame) ++key;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(track.values[2 * key + i], signal.values[2 * frame + i], 4.5) << frame;
    }
  }
}

TEST(ReplayTrack, ClipsWhatSixteenBitsCannotHold) {
  EXPECT_THAT(keys_of({3, {1e6f, -1e6f, std::nanf("")}}, 0).values, ElementsAre(32767, -32768, 0));
}

std::size_t bytes_in(const json& base64) {
  const auto text = base64.get<std::string>();
  const auto padding = std::size_t(std::count(text.begin(), text.end(), '='));
  return text.size() / 4 * 3 - padding;
}

/// Half a second of the bottle of Table 1 standing on the table, recorded.
class BottleReplay : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = make_world_template(load_scene(BINPICK_SOURCE_DIR "/scenes/blind_bottle.yaml"));
  }
  static void TearDownTestSuite() { shared_.reset(); }

  BottleReplay() : world_(shared_, centre_physics(shared_->parts.objects)) {}

  json record(long steps) {
    TrialReplay replay(world_);
    replay.note(world_, "begins");
    for (long i = 0; i < steps; ++i) {
      world_.step();
      replay.step(world_);
    }
    replay.write(world_, folder_ / "replay.json");
    std::ifstream file(folder_ / "replay.json");
    return json::parse(file);
  }

  static inline std::shared_ptr<const WorldTemplate> shared_;
  TemporaryFolder folder_;
  World world_;
};

TEST_F(BottleReplay, HasAFrameEveryFortyMilliseconds) {
  const json replay = record(500);
  EXPECT_EQ(replay["format"], 1);
  EXPECT_EQ(replay["frames"], 13);
  EXPECT_DOUBLE_EQ(replay["interval_s"], 0.04);
  EXPECT_EQ(bytes_in(replay["peak_force"]), 2u * 13u);
  EXPECT_THAT(replay["notes"][0][1].get<std::string>(), "begins");
}

TEST_F(BottleReplay, LongTrialsKeepTheirLengthAtFewerFrames) {
  TrialReplay replay(world_);
  constexpr long kSteps = 6500 * 40;
  world_.step();
  for (long i = 0; i < kSteps; ++i) replay.step(world_);
  replay.write(world_, folder_ / "replay.json");
  std::ifstream file(folder_ / "replay.json");
  const json written = json::parse(file);
  EXPECT_DOUBLE_EQ(written["interval_s"], 0.08);
  EXPECT_EQ(written["frames"], 3250);
}

TEST_F(BottleReplay, EveryMovingBodyHasAPoseAndWhatRestsHasOneKey) {
  const json replay = record(500);
  const json& names = replay["scene"]["bodies"];
  ASSERT_EQ(names.size(), replay["bodies"].size());
  EXPECT_THAT(names.dump(), testing::HasSubstr("\"link7\""));
  const auto bottle = std::find(names.begin(), names.end(), "object0") - names.begin();
  ASSERT_LT(bottle, std::ssize(names));
  const json& track = replay["bodies"][std::size_t(bottle)];
  EXPECT_EQ(bytes_in(track["frames"]), 2u);
  EXPECT_EQ(bytes_in(track["values"]), 14u);
}

TEST_F(BottleReplay, TheBottlesWeightIsSeenOnTheTable) {
  const json replay = record(500);
  ASSERT_EQ(replay["contacts"].size(), 1u);
  EXPECT_EQ(replay["contacts"][0]["first"], "cell");
  EXPECT_EQ(replay["contacts"][0]["second"], "object0");
}

TEST_F(BottleReplay, ACompliantSurfacePushesTheGripper) {
  world_.set_surface(CompliantSurface{world_.T_world_tcp().translation().z() + 0.002});
  const json replay = record(100);
  const auto of_surface = [](const json& contact) { return contact["first"] == "surface"; };
  const json& contacts = replay["contacts"];
  const auto contact = std::find_if(contacts.begin(), contacts.end(), of_surface);
  ASSERT_NE(contact, contacts.end());
  EXPECT_EQ((*contact)["second"], "gripper");
}

TEST_F(BottleReplay, RecordingLeavesTheWorldAsItIs) {
  World undisturbed(shared_, centre_physics(shared_->parts.objects));
  for (int i = 0; i < 300; ++i) undisturbed.step();
  (void)record(300);
  EXPECT_EQ(world_.save_state().numbers, undisturbed.save_state().numbers);
}

TEST_F(BottleReplay, SceneHasWhatIsSeenWithinItsMeshes) {
  const json scene = replay_scene(world_);
  std::size_t on_the_arm = 0;
  for (const json& part : scene["parts"]) {
    EXPECT_LT(part["body"].get<int>(), std::ssize(scene["bodies"]));
    on_the_arm += part["body"].get<int>() >= 0 ? 1 : 0;
    if (part["kind"] == "mesh") {
      EXPECT_LT(part["shape"].get<std::size_t>(), scene["shapes"].size());
    }
  }
  EXPECT_GT(on_the_arm, 8u);
  for (const json& shape : scene["shapes"]) {
    EXPECT_EQ(bytes_in(shape["vertices"]) % 6, 0u);
    EXPECT_EQ(bytes_in(shape["triangles"]) % 6, 0u);
  }
  EXPECT_LT(scene.dump().size(), 800'000u);
}

}  // namespace
}  // namespace binpick
