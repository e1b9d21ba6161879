#include "recognition/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <utility>
#include <variant>

#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "models/mesh_import.h"
#include "models/object_model.h"
#include "models/random.h"

namespace binpick::testing {
namespace {

/// A body of revolution-like rings, closed by fans: rings[i] has `sides` points.
TriangleMesh loft(const std::vector<std::vector<Eigen::Vector3d>>& rings) {
  TriangleMesh mesh;
  const auto sides = static_cast<std::int32_t>(rings.front().size());
  for (const auto& ring : rings) {
    mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  }
  const auto levels = static_cast<std::int32_t>(rings.size());
  for (std::int32_t level = 0; level + 1 < levels; ++level) {
    for (std::int32_t i = 0; i < sides; ++i) {
      const std::int32_t a = level * sides + i;
      const std::int32_t b = level * sides + (i + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  }
  const std::int32_t top = (levels - 1) * sides;
  for (std::int32_t i = 1; i + 1 < sides; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({top, top + i, top + i + 1});
  }
  return mesh;
}

std::vector<Eigen::Vector3d> ring(int sides, const RingProfile& at) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    points.emplace_back(at.a * std::cos(angle), at.b * std::sin(angle), at.z);
  }
  return points;
}

/// The turns about z by multiples of a full turn over `count`.
std::vector<Eigen::Isometry3d> turns(int count) {
  std::vector<Eigen::Isometry3d> group;
  for (int i = 0; i < count; ++i) {
    group.emplace_back(
        Eigen::AngleAxisd(2.0 * std::numbers::pi * i / count, Eigen::Vector3d::UnitZ()));
  }
  return group;
}

}  // namespace

TriangleMesh make_box(const Eigen::Vector3d& size) {
  const Eigen::Vector3d h = 0.5 * size;
  const auto level = [&](double z) {
    return std::vector<Eigen::Vector3d>{
        {-h.x(), -h.y(), z}, {h.x(), -h.y(), z}, {h.x(), h.y(), z}, {-h.x(), h.y(), z}};
  };
  return loft({level(-h.z()), level(h.z())});
}

TriangleMesh make_prism(int sides, double radius, double height) {
  return make_loft({{-0.5 * height, radius, radius}, {0.5 * height, radius, radius}}, sides);
}

TriangleMesh make_sphere(double radius) {
  constexpr int kLevels = 17;
  std::vector<RingProfile> profile;
  for (int i = 1; i < kLevels; ++i) {
    const double latitude = std::numbers::pi * (static_cast<double>(i) / kLevels - 0.5);
    const double r = radius * std::cos(latitude);
    profile.push_back({radius * std::sin(latitude), r, r});
  }
  return make_loft(profile, 32);
}

TriangleMesh make_loft(const std::vector<RingProfile>& profile, int sides) {
  std::vector<std::vector<Eigen::Vector3d>> rings;
  for (const RingProfile& at : profile) rings.push_back(ring(sides, at));
  return loft(rings);
}

TriangleMesh make_cup(double radius, double height, double thickness, int sides) {
  // The wall's thickness is measured across the flats.
  const double inner = radius - thickness / std::cos(std::numbers::pi / sides);
  return make_loft({{0.0, radius, radius},
                    {height, radius, radius},
                    {height, inner, inner},
                    {thickness, inner, inner}},
                   sides);
}

std::vector<ModelSource> known_objects() {
  std::vector<ModelSource> sources;
  for (const char* name : {"bottle", "amicelli", "rusk"}) {
    const ObjectModel object = load_known_object(name);
    sources.push_back({object.name, object.mesh, object.symmetries});
  }
  return sources;
}

std::vector<ModelSource> toy_objects() {
  const std::filesystem::path folder = models_directory() / "toys";
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".ply") files.push_back(entry.path());
    }
  }
  if (files.empty()) throw InputError(folder.string() + ": no toy (*.ply) is there");
  std::sort(files.begin(), files.end());
  std::vector<ModelSource> sources;
  for (const auto& file : files) sources.push_back({file.stem().string(), import_mesh(file)});
  return sources;
}

std::vector<ModelSource> open_objects() {
  const TriangleMesh bowl = make_loft({{0.0, 0.035, 0.035},
                                       {0.02, 0.06, 0.06},
                                       {0.06, 0.085, 0.085},
                                       {0.06, 0.082, 0.082},
                                       {0.022, 0.057, 0.057},
                                       {0.003, 0.033, 0.033}},
                                      48);
  return {{"cup", make_cup(0.04, 0.1, 0.003, 48), turns(48)},
          {"bowl", bowl, turns(48)},
          {"open_box", make_cup(0.1, 0.08, 0.003, 4), turns(4)}};
}

namespace {

/// The errors of one scanned model.
class ScanErrors {
 public:
  ScanErrors(const Eigen::AlignedBox3d& box, Seed seed) : random_(seed) {
    constexpr int kHoles = 8;
    for (int i = 0; i < kHoles; ++i) {
      const Eigen::Vector3d share(random_.uniform(), random_.uniform(), random_.uniform());
      holes_.push_back({box.min() + share.cwiseProduct(box.sizes()), random_.uniform(0.006, 0.02)});
    }
    // What an object stood on is seldom scanned.
    floor_ = box.min().z() + 0.002;
    for (Eigen::Vector3d& wave : waves_) {
      wave = 2.0 * std::numbers::pi / random_.uniform(0.03, 0.1) * random_.unit_vector();
    }
  }
  [[nodiscard]] bool is_lost(const Eigen::Vector3d& p) const {
    return p.z() < floor_ || std::any_of(holes_.begin(), holes_.end(), [&](const Hole& hole) {
             return (p - hole.centre).norm() < hole.radius;
           });
  }
  [[nodiscard]] Eigen::Vector3d measured(const Eigen::Vector3d& p) {
    constexpr double kNoise = 0.0003;
    constexpr double kSmooth = 0.0005;
    Eigen::Vector3d result = p;
    for (const Eigen::Vector3d& wave : waves_) {
      result += kSmooth * std::sin(wave.dot(p)) * wave.normalized();
    }
    return result + kNoise * Eigen::Vector3d(random_.normal(), random_.normal(), random_.normal());
  }

 private:
  struct Hole {
    Eigen::Vector3d centre;
    double radius = 0.0;
  };
  Random random_;
  std::vector<Hole> holes_;
  double floor_ = 0.0;
  std::array<Eigen::Vector3d, 3> waves_;
};

}  // namespace

std::vector<ModelSource> scanned(const std::vector<ModelSource>& objects) {
  constexpr double kSpacing = 0.0015;
  std::vector<ModelSource> models;
  for (const ModelSource& object : objects) {
    const auto& mesh = std::get<TriangleMesh>(object.shape);
    const Seed seed = derive_seed(Seed{1}, object.name);
    ScanErrors errors(bounding_box(mesh), seed);
    if (models.size() % 2 == 0) {
      const auto count = static_cast<std::size_t>(area(mesh) / (kSpacing * kSpacing));
      PointCloud cloud;
      const PointCloud surface = sample_surface(mesh, count, seed);
      for (std::size_t i = 0; i < surface.points.size(); ++i) {
        const Eigen::Vector3d p = surface.points[i].cast<double>();
        if (errors.is_lost(p)) continue;
        cloud.points.push_back(errors.measured(p).cast<float>());
        cloud.normals.push_back(surface.normals[i]);
      }
      cloud.width = static_cast<int>(cloud.points.size());
      cloud.height = 1;
      models.push_back({object.name, std::move(cloud), {}});
      continue;
    }
    TriangleMesh scan{mesh.vertices, {}};
    for (const auto& triangle : mesh.triangles) {
      const bool is_lost = std::any_of(triangle.begin(), triangle.end(), [&](std::int32_t corner) {
        return errors.is_lost(mesh.vertices[static_cast<std::size_t>(corner)]);
      });
      if (!is_lost) scan.triangles.push_back(triangle);
    }
    for (Eigen::Vector3d& vertex : scan.vertices) vertex = errors.measured(vertex);
    models.push_back({object.name, std::move(scan), {}});
  }
  return models;
}

ObjectSet object_set(const std::string& name) {
  if (name == "known") return {known_objects(), known_objects()};
  if (name == "toys") return {toy_objects(), toy_objects()};
  if (name == "open") return {open_objects(), open_objects()};
  if (name == "scans") return {toy_objects(), scanned(toy_objects())};
  throw InputError("no set of objects is called '" + name + "'; choose known, toys, open or scans");
}

}  // namespace binpick::testing
