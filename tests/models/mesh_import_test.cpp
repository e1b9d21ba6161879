#include "models/mesh_import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "message_of.h"
#include "models/contained_process.h"
#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

constexpr char kTetrahedron[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

TEST(MeshImport, ReadsObjInItsUnit) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = import_mesh(folder.write("t.obj", kTetrahedron), 0.001);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_TRUE(is_watertight(mesh));
  EXPECT_NEAR(volume(mesh), 1e-9 / 6, 1e-15);
}

TEST(MeshImport, WeldsTheLooseTrianglesOfStl) {
  const TemporaryFolder folder;
  const char* faces[] = {"0 0 0 0 1 0 1 0 0", "0 0 0 1 0 0 0 0 1", "1 0 0 0 1 0 0 0 1",
                         "0 1 0 0 0 0 0 0 1"};
  std::string stl = "solid t\n";
  for (const char* face : faces) {
    std::istringstream numbers(face);
    stl += "facet normal 0 0 0\nouter loop\n";
    std::string x;
    std::string y;
    std::string z;
    while (numbers >> x >> y >> z) stl += "vertex " + x + " " + y + " " + z + "\n";
    stl += "endloop\nendfacet\n";
  }
  const TriangleMesh mesh = import_mesh(folder.write("t.stl", stl + "endsolid t\n"));
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_TRUE(is_watertight(mesh));
}

TEST(MeshImport, DropsTrianglesWithoutAreaAndUnusedVertices) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = import_mesh(folder.write(
      "t.obj", "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 0\nf 2 3 4\nf 2 4 5\nf 2 2 3\n"));
  EXPECT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.triangles.size(), 1u);
}

TEST(MeshImport, SeveralFilesComeBackInOrder) {
  const TemporaryFolder folder;
  const auto small = folder.write("small.obj", kTetrahedron);
  const auto flat = folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto meshes = import_meshes({small, flat, small});
  ASSERT_EQ(meshes.size(), 3u);
  EXPECT_EQ(meshes[0].triangles.size(), 4u);
  EXPECT_EQ(meshes[1].triangles.size(), 1u);
  EXPECT_EQ(meshes[2].triangles.size(), 4u);
}

TEST(MeshImport, BrokenFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& text) {
    const auto file = folder.write(name, text);
    const auto good = folder.write("good.obj", kTetrahedron);
    EXPECT_THAT(message_of<InputError>([&] { static_cast<void>(import_mesh(file)); }),
                HasSubstr(file.string()));
    EXPECT_THAT(message_of<InputError>([&] {
                  static_cast<void>(import_meshes({good, file}));
                }),
                HasSubstr(file.string()));
  };
  refused("empty.obj", "");
  refused("points.obj", "v 0 0 0\nv 1 0 0\n");
  refused("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  refused("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n");
  refused("noise.stl", std::string(400, '\x7f'));
  refused("cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n");
  refused("other.dae", "<COLLADA/>");
  std::string stl(84, '\0');
  stl[80] = stl[81] = stl[82] = '\x7f';  // promises eight million triangles
  refused("huge.stl", stl);
  EXPECT_THROW(static_cast<void>(import_mesh(folder.path() / "absent.obj")), InputError);
}

TEST(ContainedProcess, ReturnsTheAnswer) {
  const ContainedResult result =
      run_contained([] { return std::vector<std::byte>(1000000, std::byte{7}); });
  ASSERT_TRUE(result.ok) << result.problem;
  EXPECT_EQ(result.bytes, std::vector<std::byte>(1000000, std::byte{7}));
}

TEST(ContainedProcess, AnExceptionComesBackAsText) {
  const ContainedResult result =
      run_contained([]() -> std::vector<std::byte> { throw std::runtime_error("no such luck"); });
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(result.problem, "no such luck");
}

TEST(ContainedProcess, ACrashIsContained) {
  const ContainedResult result = run_contained([]() -> std::vector<std::byte> { std::abort(); });
  EXPECT_FALSE(result.ok);
  EXPECT_THAT(result.problem, HasSubstr("signal"));
}

TEST(ContainedProcess, AHangIsContained) {
  ContainmentLimits limits;
  limits.cpu_seconds = 0.3;
  const auto begin = std::chrono::steady_clock::now();
  const ContainedResult result = run_contained(
      []() -> std::vector<std::byte> {
        volatile bool forever = true;
        while (forever) {
        }
        return {};
      },
      limits);
  EXPECT_FALSE(result.ok);
  EXPECT_THAT(result.problem, HasSubstr("longer than 0.3 s of processor time"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST(ContainedProcess, AWaitWithoutEndIsContained) {
  ContainmentLimits limits;
  limits.wall_seconds = 0.2;
  const ContainedResult result = run_contained(
      []() -> std::vector<std::byte> {
        while (true) pause();
      },
      limits);
  EXPECT_FALSE(result.ok);
  EXPECT_THAT(result.problem, HasSubstr("longer than 0.2 s"));
}

TEST(ContainedProcess, GreedIsContained) {
  ContainmentLimits limits;
  limits.output_bytes = 1000;
  EXPECT_FALSE(run_contained([] { return std::vector<std::byte>(2000); }, limits).ok);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limits.memory_bytes = 64u << 20;
  const ContainedResult result =
      run_contained([] { return std::vector<std::byte>(std::size_t{8} << 30); }, limits);
  EXPECT_FALSE(result.ok);
  EXPECT_THAT(result.problem, HasSubstr("memory"));
#endif
}

}  // namespace
}  // namespace binpick
