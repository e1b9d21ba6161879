#include "models/object_model.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <set>

#include "models/config_visitor.h"
#include "models/errors.h"
#include "models/grasp_family.h"
#include "models/mesh_geometry.h"
#include "models/mesh_import.h"
#include "models/resource_path.h"
#include "models/symmetry.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

struct SymmetryGenerator {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double angle = 0.0;

  void visit(ConfigVisitor& visitor) {
    visitor.vector("axis", axis, {-1.0, 1.0, 1.0}, Presence::kRequired);
    visitor.number("angle_deg", angle, {0.0, 180.0, kDegree}, Presence::kRequired);
    if (visitor.reading() && !(std::abs(axis.norm() - 1.0) < 1e-6)) {
      visitor.problem("axis", "must be a unit vector");
    }
  }
};

/// object.yaml, field by field.
struct ObjectDescription {
  std::filesystem::path directory;
  std::string mesh;
  std::vector<std::string> collision;
  std::vector<double> colour;
  ObjectPhysics physics;
  std::string mass_distribution = "solid";
  std::vector<SymmetryGenerator> symmetries;
  std::vector<GraspFamily> grasps;

  void visit(ConfigVisitor& visitor) {
    const NumberSpec friction{0.0, 2.0, 1.0};
    visitor.text("mesh", mesh, Presence::kRequired);
    visitor.texts("collision", collision, Presence::kRequired);
    visitor.numbers("colour", colour, 4, {0.0, 1.0, 1.0}, Presence::kRequired);
    visitor.interval("mass", physics.mass, {0.001, 100.0, 1.0}, Presence::kRequired);
    visitor.choice("mass_distribution", mass_distribution, {"solid", "shell"});
    visitor.interval("table_friction", physics.table_friction, friction, Presence::kRequired);
    visitor.interval("object_friction", physics.object_friction, friction, Presence::kRequired);
    visitor.interval("pad_friction", physics.pad_friction, friction, Presence::kRequired);
    visitor.elements("symmetries", symmetries);
    visitor.elements("grasps", grasps);
    if (visitor.reading()) check(visitor);
  }

  void check(ConfigVisitor& visitor) const {
    if (collision.empty()) visitor.problem("collision", "needs at least one convex mesh");
    check_file(visitor, "mesh", mesh);
    for (const std::string& file : collision) check_file(visitor, "collision", file);
    if (!group()) visitor.problem("symmetries", "these rotations do not form a finite group");
    std::set<std::string> names;
    for (const GraspFamily& family : grasps) {
      if (!names.insert(family.name).second) {
        visitor.problem("grasps", fmt::format("two grasps are called '{}'", family.name));
      }
    }
  }

  void check_file(ConfigVisitor& visitor, std::string_view key, const std::string& file) const {
    if (file.empty()) return;  // a missing key has been reported already
    try {
      static_cast<void>(resolve_inside(directory, file));
    } catch (const InputError& error) {
      visitor.problem(key, error.what());
    }
  }

  [[nodiscard]] std::optional<std::vector<Eigen::Isometry3d>> group() const {
    std::vector<Eigen::Matrix3d> rotations;
    for (const SymmetryGenerator& generator : symmetries) {
      rotations.push_back(
          Eigen::AngleAxisd(generator.angle, generator.axis.normalized()).toRotationMatrix());
    }
    return rotation_group(rotations);
  }
};

void check_solid(const TriangleMesh& mesh, const std::string& file) {
  if (!is_watertight(mesh)) {
    throw InputError(fmt::format("{}: the surface is not closed; close its holes", file));
  }
  if (volume(mesh) <= 0.0) {
    throw InputError(fmt::format("{}: the triangles face inward; turn them round", file));
  }
}

void check_convex(const TriangleMesh& mesh, const std::string& file) {
  constexpr double kTolerance = 1e-5;  // files are written to the micrometre
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(triangle[0])];
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(triangle[1])];
    const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(triangle[2])];
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      if (normal.dot(vertex - a) > kTolerance) {
        throw InputError(fmt::format("{}: not convex; split it into convex pieces", file));
      }
    }
  }
}

}  // namespace

ObjectModel load_object_model(const std::filesystem::path& directory) {
  ObjectDescription description;
  description.directory = directory;
  read_yaml(directory / "object.yaml", [&](ConfigVisitor& visitor) { description.visit(visitor); });

  std::vector<std::filesystem::path> files{resolve_inside(directory, description.mesh)};
  for (const std::string& file : description.collision) {
    files.push_back(resolve_inside(directory, file));
  }
  std::vector<TriangleMesh> meshes = import_meshes(files);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    check_solid(meshes[i], files[i].string());
    if (i > 0) check_convex(meshes[i], files[i].string());
  }

  ObjectModel model;
  model.name = std::filesystem::canonical(directory).filename().string();
  model.mesh = std::move(meshes.front());
  model.collision.assign(std::make_move_iterator(meshes.begin() + 1),
                         std::make_move_iterator(meshes.end()));
  model.colour = Eigen::Vector4d(description.colour.data()).cast<float>();
  model.physics = description.physics;
  const MassProperties properties = description.mass_distribution == "shell"
                                        ? shell_properties(model.mesh)
                                        : solid_properties(model.mesh);
  model.physics.p_model_com = properties.com;
  model.physics.inertia_per_mass = properties.inertia;
  model.symmetries = description.group().value();
  for (const GraspFamily& family : description.grasps) {
    std::vector<Grasp> members = family.expand();
    model.grasps.insert(model.grasps.end(), std::make_move_iterator(members.begin()),
                        std::make_move_iterator(members.end()));
  }
  return model;
}

ObjectModel load_known_object(const std::string& name) {
  const std::filesystem::path objects = models_directory() / "objects";
  std::error_code error;
  if (name.empty() || name.find('/') != std::string::npos || name.front() == '.' ||
      !std::filesystem::is_directory(objects / name, error)) {
    throw InputError(fmt::format("{}: there is no object '{}'; its folders name the known ones",
                                 objects.string(), name));
  }
  return load_object_model(objects / name);
}

std::filesystem::path models_directory() {
  const char* directory = std::getenv("BINPICK_MODELS");
  if (directory != nullptr && *directory != '\0') return directory;
  return std::filesystem::path(BINPICK_SOURCE_DIR) / "models";
}

}  // namespace binpick
