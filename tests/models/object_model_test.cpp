#include "models/object_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>

#include "message_of.h"
#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

const char* const kObjects[] = {"bottle", "amicelli", "rusk"};

double distance_to_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
  const Eigen::Vector3d foot = p - normal.dot(p - a) * normal;
  const auto inside = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (to - from).cross(foot - from).dot(normal) >= 0.0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return (p - foot).norm();
  const auto to_edge = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector3d edge = to - from;
    const double t = std::clamp((p - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    return (p - from - t * edge).norm();
  };
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

double distance_to_mesh(const Eigen::Vector3d& p, const TriangleMesh& mesh) {
  double least = 1e9;
  for (const auto& t : mesh.triangles) {
    least = std::min(least, distance_to_triangle(p, mesh.vertices[std::size_t(t[0])],
                                                 mesh.vertices[std::size_t(t[1])],
                                                 mesh.vertices[std::size_t(t[2])]));
  }
  return least;
}

class EveryObject : public ::testing::TestWithParam<const char*> {
 protected:
  const ObjectModel model_ = load_known_object(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Objects, EveryObject, ::testing::ValuesIn(kObjects));

TEST_P(EveryObject, MeshIsClosedOutwardAndCentred) {
  EXPECT_TRUE(is_watertight(model_.mesh));
  EXPECT_GT(volume(model_.mesh), 0.0);
  EXPECT_LT(bounding_box(model_.mesh).center().norm(), 1e-6);
}

TEST_P(EveryObject, InertiaIsThatOfABody) {
  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(model_.physics.inertia_per_mass).eigenvalues();
  EXPECT_GT(principal[0], 0.0);
  EXPECT_GT(principal[0] + principal[1], principal[2]);
}

TEST_P(EveryObject, CollisionPiecesCoverTheMeshClosely) {
  double pieces = 0.0;
  for (const TriangleMesh& piece : model_.collision) pieces += volume(piece);
  EXPECT_GT(pieces, 0.99 * volume(model_.mesh));
  EXPECT_LT(pieces, 1.06 * volume(model_.mesh));
  // No vertex of the surface stands out of all pieces by more than 2 mm.
  for (const Eigen::Vector3d& vertex : model_.mesh.vertices) {
    double least = 1e9;
    for (const TriangleMesh& piece : model_.collision) {
      double outside = -1e9;
      for (const auto& t : piece.triangles) {
        const Eigen::Vector3d& a = piece.vertices[std::size_t(t[0])];
        const Eigen::Vector3d& b = piece.vertices[std::size_t(t[1])];
        const Eigen::Vector3d& c = piece.vertices[std::size_t(t[2])];
        outside = std::max(outside, (b - a).cross(c - a).normalized().dot(vertex - a));
      }
      least = std::min(least, outside);
    }
    EXPECT_LT(least, 0.002);
  }
}

TEST_P(EveryObject, SymmetriesFormAGroup) {
  const auto& group = model_.symmetries;
  ASSERT_TRUE(group.front().isApprox(Eigen::Isometry3d::Identity()));
  for (const Eigen::Isometry3d& a : group) {
    for (const Eigen::Isometry3d& b : group) {
      int hits = 0;
      for (const Eigen::Isometry3d& c : group) hits += (a * b).isApprox(c, 1e-9) ? 1 : 0;
      EXPECT_EQ(hits, 1);
    }
  }
}

TEST_P(EveryObject, EquivalentPosesLeaveTheSurfaceInPlace) {
  const PointCloud cloud = sample_surface(model_.mesh, 60, 11);
  for (const Eigen::Isometry3d& T : model_.symmetries) {
    for (const Eigen::Vector3f& point : cloud.points) {
      EXPECT_LT(distance_to_mesh(T * point.cast<double>(), model_.mesh), 0.0025);
    }
  }
}

TEST_P(EveryObject, GraspNamesAreUnique) {
  std::set<std::string> names;
  for (const Grasp& grasp : model_.grasps) EXPECT_TRUE(names.insert(grasp.name).second);
}

TEST(ObjectModel, SizesAreTheMeasuredOnes) {
  const auto size = [](const char* name) -> Eigen::Vector3d {
    return bounding_box(load_known_object(name).mesh).sizes();
  };
  EXPECT_LT((size("bottle") - Eigen::Vector3d(0.1034, 0.0702, 0.183)).norm(), 5e-4);
  EXPECT_LT((size("amicelli") - Eigen::Vector3d(0.0987, 0.0855, 0.1425)).norm(), 5e-4);
  EXPECT_LT((size("rusk") - Eigen::Vector3d(0.148, 0.145, 0.080)).norm(), 1e-6);
  EXPECT_NEAR(volume(load_known_object("rusk").mesh), 0.148 * 0.145 * 0.080, 1e-9);
  EXPECT_NEAR(volume(load_known_object("amicelli").mesh),
              std::sqrt(3.0) / 2 * 0.0855 * 0.0855 * 0.1425, 1e-7);
}

TEST(ObjectModel, TheBottleFollowsItsMeasuredSlices) {
  const TriangleMesh mesh = load_known_object("bottle").mesh;
  const double slices[][3] = {{.013, .0481, .0316}, {.053, .0488, .0285}, {.063, .0476, .0283},
                              {.103, .0517, .0346}, {.123, .0350, .0300}, {.133, .0250, .0230}};
  for (const auto& slice : slices) {
    double a = 0.0;
    double b = 0.0;
    for (const Eigen::Vector3d& v : mesh.vertices) {
      if (std::abs(v.z() + 0.0915 - slice[0]) > 1e-5) continue;
      a = std::max(a, v.x());
      b = std::max(b, v.y());
    }
    EXPECT_NEAR(a, slice[1], 1e-5) << "at height " << slice[0];
    EXPECT_NEAR(b, slice[2], 1e-5) << "at height " << slice[0];
  }
}

TEST(ObjectModel, SymmetryOrdersAreThoseOfTheShapes) {
  EXPECT_EQ(load_known_object("bottle").symmetries.size(), 2u);
  EXPECT_EQ(load_known_object("amicelli").symmetries.size(), 12u);
  EXPECT_EQ(load_known_object("rusk").symmetries.size(), 8u);
}

TEST(ObjectModel, TableOneGraspsTheBottleAcrossItsWideAxis) {
  const ObjectModel bottle = load_known_object("bottle");
  const Grasp& grasp = bottle.grasps.front();
  EXPECT_EQ(grasp.name, "top across wide axis");
  EXPECT_NEAR(grasp.pre_opening, 0.110, 1e-12);
  EXPECT_LT((grasp.T_object_grasp.linear().col(2) + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((grasp.T_object_grasp.linear().col(1) - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_NEAR(grasp.T_object_grasp.translation().z() + 0.0915, 0.095, 1e-9);
}

class BrokenObject : public ::testing::Test {
 protected:
  BrokenObject() {
    std::filesystem::copy(models_directory() / "objects" / "rusk", folder_.path() / "rusk");
    text_ = read_whole_file(file());
  }

  [[nodiscard]] std::filesystem::path file() const {
    return folder_.path() / "rusk" / "object.yaml";
  }

  /// The message for the description with `from` replaced by `to`.
  std::string message_with(const std::string& from, const std::string& to) {
    std::string text = text_;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos);
    text.replace(at, from.size(), to);
    folder_.write("rusk/object.yaml", text);
    return message_of<InputError>(
        [&] { static_cast<void>(load_object_model(folder_.path() / "rusk")); });
  }

  TemporaryFolder folder_;
  std::string text_;
};

TEST_F(BrokenObject, UnbrokenItLoads) {
  EXPECT_EQ(load_object_model(folder_.path() / "rusk").grasps.size(),
            load_known_object("rusk").grasps.size());
}

TEST_F(BrokenObject, MistakesAreNamedWithTheirPlace) {
  EXPECT_THAT(message_with("mass: [0.25", "mass: [-0.25"), HasSubstr("object.yaml:"));
  EXPECT_THAT(message_with("rusk.obj", "/etc/passwd"), HasSubstr("relative"));
  EXPECT_THAT(message_with("rusk.obj", "../rusk/rusk.obj"), HasSubstr("relative"));
  EXPECT_THAT(message_with("rusk.obj", "absent.obj"), HasSubstr("absent.obj"));
  EXPECT_THAT(message_with("angle_deg: 90", "angle_deg: 1.234"), HasSubstr("finite group"));
  EXPECT_THAT(message_with("jaw: [0, 1, 0]", "jaw: [0, 0, 1]"), HasSubstr("perpendicular"));
  EXPECT_THAT(message_with("pre_opening: 0.160", "pre_opening: 0.200"), HasSubstr("outside"));
  EXPECT_THAT(message_with("top across x", "top across y"), HasSubstr("two grasps"));
  EXPECT_THAT(message_with("colour", "color"), HasSubstr("unknown key"));
}

TEST_F(BrokenObject, AnOpenOrHollowedMeshIsRefused) {
  std::string mesh = read_whole_file(folder_.path() / "rusk" / "rusk.obj");
  mesh.erase(mesh.rfind("\nf ") + 1);
  folder_.write("rusk/rusk.obj", mesh);
  EXPECT_THAT(message_of<InputError>(
                  [&] { static_cast<void>(load_object_model(folder_.path() / "rusk")); }),
              HasSubstr("not closed"));
}

TEST(ObjectModel, UnknownNamesAreRefused) {
  EXPECT_THROW(static_cast<void>(load_known_object("teapot")), InputError);
  EXPECT_THROW(static_cast<void>(load_known_object("../objects/rusk")), InputError);
  EXPECT_THROW(static_cast<void>(load_known_object("")), InputError);
}

TEST(MakeModels, TheCommittedMeshesAreWhatTheScriptWrites) {
  const TemporaryFolder folder;
  const std::string command = "python3 '" BINPICK_SOURCE_DIR "/scripts/make_models.py' --out '" +
                              folder.path().string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  int compared = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
    if (!entry.is_regular_file()) continue;
    const auto relative = std::filesystem::relative(entry.path(), folder.path());
    EXPECT_EQ(read_whole_file(entry.path()),
              read_whole_file(std::filesystem::path(BINPICK_SOURCE_DIR) / "models" / relative))
        << relative;
    ++compared;
  }
  EXPECT_EQ(compared, 20);
}

}  // namespace
}  // namespace binpick
