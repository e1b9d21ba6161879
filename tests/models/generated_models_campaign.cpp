#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "models/mesh_geometry.h"
#include "models/model_file.h"
#include "models/object_model.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), folder));
  }
  return files;
}

TEST(GeneratedModels, ScriptWritesTheBytesInTheRepository) {
  const TemporaryFolder folder;
  const std::string script = std::string(BINPICK_SOURCE_DIR) + "/scripts/make_models.py";
  const std::string command =
      "PYTHONDONTWRITEBYTECODE=1 python3 '" + script + "' --out '" + folder.path().string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const fs::path models = fs::path(BINPICK_SOURCE_DIR) / "models";
  const std::vector<fs::path> files = files_below(folder.path());
  EXPECT_GT(files.size(), 15U);
  for (const fs::path& file : files) {
    EXPECT_EQ(read_whole_file(folder.path() / file), read_whole_file(models / file)) << file;
  }
}

class Toy : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Toy, testing::Values("ram", "goose", "stego", "gnome"),
                         [](const auto& each) { return std::string(each.param); });

TEST_P(Toy, IsAClosedFigureOfTheSizeOfAHand) {
  const fs::path file = models_directory() / "toys" / (std::string(GetParam()) + ".ply");
  EXPECT_LT(fs::file_size(file), 500'000U);
  const auto mesh = std::get<TriangleMesh>(read_model_file(file));
  EXPECT_TRUE(is_watertight(mesh));
  EXPECT_GT(volume(mesh), 2e-4);
  EXPECT_GT(mesh.triangles.size(), 6000U);
  EXPECT_LT(mesh.triangles.size(), 12'000U);
  double diameter = 0.0;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 5) {
    for (std::size_t j = 0; j < i; j += 5) {
      diameter = std::max(diameter, (mesh.vertices[i] - mesh.vertices[j]).norm());
    }
  }
  EXPECT_GT(diameter, 0.12);
  EXPECT_LT(diameter, 0.22);
}

}  // namespace
}  // namespace binpick
