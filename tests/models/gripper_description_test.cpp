#include "models/gripper_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "message_of.h"
#include "models/errors.h"
#include "models/object_model.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

TEST(Gripper, HasTheCellsStrokeAndToolCentre) {
  const GripperDescription gripper = load_gripper();
  EXPECT_EQ(gripper.stroke.low, 0.0);
  EXPECT_EQ(gripper.stroke.high, 0.160);
  EXPECT_NEAR(gripper.T_flange_tcp.translation().z(), 0.20, 1e-12);
  EXPECT_NEAR(gripper.closed_width, 0.003, 1e-12);
  // A bottle 0.183 m high, held 0.095 m above the table, ends below the palm.
  EXPECT_LT(gripper.body_size.z(), 0.20 - (0.183 - 0.095) - 0.005);
}

TEST(Gripper, ToolInertiaIsThatOfItsThreeBodies) {
  const GripperDescription gripper = load_gripper();
  for (const double width : {0.0, 0.08, 0.16}) {
    const BodyInertia tool = gripper.tool_inertia(width);
    EXPECT_NEAR(tool.mass, 1.6, 1e-12);
    // Jaws are alike: the centre of mass stays in the middle plane.
    EXPECT_NEAR(tool.com.y(), 0.0, 1e-12);
    // About x the jaws' distance counts, about y it does not (parallel axes).
    const double arm = 0.5 * width + gripper.jaw.com.y();
    EXPECT_NEAR(tool.inertia(2, 2),
                gripper.body.inertia(2, 2) + 2 * gripper.jaw.inertia(2, 2) +
                    2 * gripper.jaw.mass * arm * arm,
                1e-12);
    EXPECT_NEAR(tool.inertia(1, 1), gripper.tool_inertia(0.0).inertia(1, 1), 1e-12);
    EXPECT_GT(tool.inertia.determinant(), 0.0);
  }
}

TEST(Gripper, InconsistentLengthsAreRefused) {
  std::string text = read_whole_file(models_directory() / "gripper" / "gripper.yaml");
  const TemporaryFolder folder;
  const auto message_with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    const auto file = folder.write("gripper.yaml", changed);
    return message_of<InputError>([&] { static_cast<void>(load_gripper_description(file)); });
  };
  EXPECT_THAT(message_with("finger_length: 0.110", "finger_length: 0.100"), HasSubstr("housing"));
  EXPECT_THAT(message_with("tip_beyond_tcp: 0.015", "tip_beyond_tcp: 0.005"),
              HasSubstr("gripper.yaml:"));
  EXPECT_THAT(message_with("max_force: 80", "max_force: -80"), HasSubstr("outside"));
}

}  // namespace
}  // namespace binpick
