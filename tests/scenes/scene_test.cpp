#include "scenes/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "models/errors.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kScenes = std::filesystem::path(BINPICK_SOURCE_DIR) / "scenes";

// A folder of scene files that vanishes with the test.
class SceneFolder : public ::testing::Test {
 protected:
  SceneFolder()
      : folder_(std::filesystem::path(::testing::TempDir()) /
                ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
  }
  ~SceneFolder() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  // What load_scene complains about.
  std::string complaint(const std::string& text) const {
    try {
      (void)load_scene(write("scene.yaml", text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

constexpr const char* kOneBottle = "standing:\n  - model: bottle\n";

TEST(Scene, EverySceneOfTheRepositoryLoads) {
  int loaded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".yaml" || entry.path().stem() == "cell") continue;
    const Scene scene = load_scene(entry.path());
    EXPECT_EQ(scene.name, entry.path().stem());
    EXPECT_FALSE(scene.object_names().empty());
    EXPECT_EQ(scene.containers.size(), 3u) << entry.path();
    ++loaded;
  }
  EXPECT_GE(loaded, 5);
}

TEST(Scene, PileHoldsThreeBottlesTwoAmicelliTwoRusk) {
  const std::vector<std::string> names = load_scene(kScenes / "pile.yaml").object_names();
  EXPECT_THAT(names, ::testing::ElementsAre("bottle", "bottle", "bottle", "amicelli", "amicelli",
                                            "rusk", "rusk"));
}

TEST(Scene, CameraLooksAsMeasured) {
  const SceneCamera camera = load_scene(kScenes / "pile.yaml").camera;
  const Eigen::Isometry3d T = camera.T_world_camera();
  EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-12);
  const double tilt = std::acos(-T.linear().col(2).z()) / kDegree;
  EXPECT_NEAR(tilt, 33.6, 0.1);
  EXPECT_NEAR((camera.position - camera.look_at).norm(), 0.93, 0.02);
  // The point that it looks at lies on the optical axis, ahead.
  const Eigen::Vector3d seen = T.inverse() * camera.look_at;
  EXPECT_NEAR(seen.head<2>().norm(), 0.0, 1e-12);
  EXPECT_GT(seen.z(), 0.0);
  // Up in the world is up in the image, where v falls.
  EXPECT_LT((T.inverse() * (camera.look_at + Eigen::Vector3d(0.0, 0.0, 0.1))).y(), 0.0);
  EXPECT_DOUBLE_EQ(camera.intrinsics().cx, 319.5);
}

TEST(Scene, EverythingToHandleLiesWithinReach) {
  const Scene scene = load_scene(kScenes / "pile.yaml");
  for (const Place& place : cell_layout(scene).places) {
    for (const Eigen::Vector2d& slot : place.slots) {
      EXPECT_GT(slot.norm(), 0.39) << place.name;
      EXPECT_LT(slot.norm(), 0.75) << place.name;
    }
  }
}

TEST(Scene, LayoutTellsTheRobotWhereThingsBelong) {
  const CellLayout layout = cell_layout(load_scene(kScenes / "pile.yaml"));
  EXPECT_TRUE(layout.pick_region.contains(Eigen::Vector2d(0.55, 0.0)));
  ASSERT_EQ(layout.places.size(), 3u);
  EXPECT_THAT(layout.places[0].objects, ::testing::ElementsAre("bottle"));
  EXPECT_EQ(layout.places[0].slots.size(), 3u);
  EXPECT_GT(layout.places[0].rim_height, 0.05);
  EXPECT_THAT(layout.places[2].objects, ::testing::ElementsAre("rusk"));
  EXPECT_EQ(layout.places[2].rim_height, 0.0);
  EXPECT_GT(layout.transfer_height, layout.places[0].rim_height);
}

TEST(Scene, RestingNamesSayWhichModelAxisPointsUp) {
  StandingObject object;
  const auto up = [&](const char* resting) {
    object.resting = resting;
    return Eigen::Vector3d(object.R_world_object().transpose() * Eigen::Vector3d::UnitZ());
  };
  object.yaw = 0.7;
  EXPECT_TRUE(up("upright").isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(up("upside_down").isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(up("x_up").isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(up("y_up").isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(Scene, WrittenAndReadBackIsTheSame) {
  Scene scene = load_scene(kScenes / "pile.yaml");
  const std::string text = write_yaml([&](ConfigVisitor& visitor) { scene.visit(visitor); });
  Scene back;
  read_yaml_text(text, "back", [&](ConfigVisitor& visitor) { back.visit(visitor); });
  EXPECT_EQ(write_yaml([&](ConfigVisitor& visitor) { back.visit(visitor); }), text);
  EXPECT_EQ(back.overview, scene.overview);
}

TEST_F(SceneFolder, ExtendedFilesGiveTheDefaults) {
  write("base.yaml", "transfer_height: 0.5\ncamera:\n  focal_length_px: 600\n  width: 320\n");
  const Scene scene = load_scene(
      write("scene.yaml", std::string("extends: base.yaml\ncamera:\n  width: 160\n") + kOneBottle));
  EXPECT_EQ(scene.transfer_height, 0.5);
  EXPECT_EQ(scene.camera.focal_length, 600.0);
  EXPECT_EQ(scene.camera.width, 160);
  EXPECT_EQ(scene.name, "scene");
}

TEST_F(SceneFolder, CirclesOfExtensionsAreRefused) {
  EXPECT_THAT(complaint("extends: scene.yaml\n"), HasSubstr("circle"));
}

TEST_F(SceneFolder, UnknownKeysAreReportedWithTheirPlace) {
  const std::string message = complaint(std::string(kOneBottle) + "camera:\n  zoom: 2\n");
  EXPECT_THAT(message, HasSubstr("scene.yaml:4:3"));
  EXPECT_THAT(message, HasSubstr("camera.zoom"));
}

TEST_F(SceneFolder, EveryInconsistencyIsReportedAtOnce) {
  const std::string message = complaint(
      "standing:\n  - model: bottle\n    position: [0.9, 0.9]\n"
      "containers:\n"
      "  - {name: a, objects: [rusk], centre: [0.5, 0.0], size: [0.2, 0.2]}\n"
      "  - {name: b, objects: [rusk], centre: [0, 0.6], size: [0.2, 0.2], slots: [{at: [0, "
      "0]}]}\n");
  EXPECT_THAT(message, HasSubstr("outside the pick region"));
  EXPECT_THAT(message, HasSubstr("'a' overlaps the pick region"));
  EXPECT_THAT(message, HasSubstr("'rusk' belongs to two"));
  EXPECT_THAT(message, HasSubstr("a slot of 'b' lies outside"));
}

TEST_F(SceneFolder, SceneWithoutObjectsIsRefused) {
  EXPECT_THAT(complaint("arrangement: pile\n"), HasSubstr("at least one entry in 'objects'"));
}

TEST_F(SceneFolder, MissingFileIsNamed) {
  EXPECT_THROW((void)load_scene(folder_ / "none.yaml"), InputError);
  EXPECT_THAT(complaint("extends: none.yaml\n"), HasSubstr("none.yaml"));
}

}  // namespace
}  // namespace binpick
