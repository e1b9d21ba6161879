#include "recognition/synthetic_objects.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "models/mesh_geometry.h"
#include "recognition/shapes.h"

namespace binpick::testing {
namespace {

constexpr double kCoverSpacing = 0.003;  // m, below the cell of the height map

/// Splits every edge longer than `longest` in the middle, the same way on both of its sides.
TriangleMesh split_edges(const TriangleMesh& mesh, double longest, bool& any) {
  TriangleMesh result{mesh.vertices, {}};
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) -> std::int32_t {
    const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(a)];
    const Eigen::Vector3d& q = mesh.vertices[static_cast<std::size_t>(b)];
    if ((p - q).norm() <= longest) return -1;
    const auto [place, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(result.vertices.size()));
    if (is_new) result.vertices.push_back(0.5 * (p + q));
    return place->second;
  };
  for (std::array<std::int32_t, 3> t : mesh.triangles) {
    std::array<std::int32_t, 3> m = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
    const auto split = std::count_if(m.begin(), m.end(), [](std::int32_t i) { return i >= 0; });
    any = any || split > 0;
    if (split == 0) {
      result.triangles.push_back(t);
      continue;
    }
    // Turn the triangle so that its first edge is split, and with two, the last is not.
    while (m[0] < 0 || (split == 2 && m[2] >= 0)) {
      std::rotate(t.begin(), t.begin() + 1, t.end());
      std::rotate(m.begin(), m.begin() + 1, m.end());
    }
    if (split == 1) {
      result.triangles.push_back({t[0], m[0], t[2]});
      result.triangles.push_back({m[0], t[1], t[2]});
    } else if (split == 2) {
      result.triangles.push_back({m[0], t[1], m[1]});
      result.triangles.push_back({t[0], m[0], m[1]});
      result.triangles.push_back({t[0], m[1], t[2]});
    } else {
      result.triangles.push_back({t[0], m[0], m[2]});
      result.triangles.push_back({m[0], t[1], m[1]});
      result.triangles.push_back({m[2], m[1], t[2]});
      result.triangles.push_back({m[0], m[1], m[2]});
    }
  }
  return result;
}

void measure_sides(Shape& shape) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : shape.vertices) box.extend(vertex);
  shape.sides = box.sizes();
  std::sort(shape.sides.data(), shape.sides.data() + 3, std::greater<>());
}

/// A smooth random displacement: a few waves as long as half the object and more.
class WaveField {
 public:
  WaveField(double wavelength, Seed seed) {
    Random random(seed);
    for (Wave& wave : waves_) {
      wave.direction =
          2.0 * std::numbers::pi / (wavelength * random.uniform(0.5, 1.5)) * random.unit_vector();
      wave.displacement = random.unit_vector();
      wave.phase = random.uniform(0.0, 2.0 * std::numbers::pi);
    }
  }
  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& p) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Wave& wave : waves_) {
      sum += std::cos(wave.direction.dot(p) + wave.phase) * wave.displacement;
    }
    return sum;
  }

 private:
  struct Wave {
    Eigen::Vector3d direction, displacement;
    double phase = 0.0;
  };
  std::array<Wave, 4> waves_;
};

/// Whether two sides of `shape` are within 8 % of two sides of a model.
bool resembles(const Shape& shape, std::span<const Shape> models) {
  constexpr std::array<std::array<int, 2>, 3> kPairs = {{{0, 1}, {0, 2}, {1, 2}}};
  const auto alike = [](float a, float b) { return std::abs(a - b) < 0.08f * b; };
  for (const Shape& model : models) {
    for (const auto& [i, j] : kPairs) {
      for (const auto& [k, l] : kPairs) {
        if (alike(shape.sides[i], model.sides[k]) && alike(shape.sides[j], model.sides[l])) {
          return true;
        }
      }
    }
  }
  return false;
}

/// A body of revolution, squeezed to an oval; from the lowest ring to the highest.
TriangleMesh make_vase(Random& random) {
  const double height = random.uniform(0.08, 0.2);
  const double radius = random.uniform(0.025, 0.05);
  const double wave = random.uniform(2.0, 8.0);
  const double phase = random.uniform(0.0, 6.0);
  const double oval = random.uniform(0.6, 1.0);
  std::vector<RingProfile> profile;
  for (int i = 0; i <= 16; ++i) {
    const double share = i / 16.0;
    const double r = radius * (1.0 + 0.35 * std::cos(wave * share + phase));
    profile.push_back({height * (share - 0.5), r, oval * r});
  }
  return make_loft(profile, 40);
}

TriangleMesh make_blob(Random& random) {
  TriangleMesh mesh = make_sphere(1.0);
  const Eigen::Vector3d axes(random.uniform(0.03, 0.07), random.uniform(0.03, 0.07),
                             random.uniform(0.03, 0.07));
  const WaveField field(1.5, random.bits());
  const double strength = random.uniform(0.0, 0.12);
  for (Eigen::Vector3d& p : mesh.vertices) {
    const Eigen::Vector3d direction = p;
    p = axes.cwiseProduct(direction * (1.0 + strength * field.at(direction).sum()));
  }
  return mesh;
}

TriangleMesh make_random_mesh(Random& random) {
  switch (random.index(8)) {
    case 0:
    case 1:
      return make_box(
          {random.uniform(0.04, 0.22), random.uniform(0.04, 0.16), random.uniform(0.03, 0.12)});
    case 2:
      return make_prism(3 + static_cast<int>(random.index(6)), random.uniform(0.03, 0.07),
                        random.uniform(0.06, 0.2));
    case 3:
      return make_prism(48, random.uniform(0.02, 0.06), random.uniform(0.05, 0.22));
    case 4:
      return make_vase(random);
    case 5:
      return make_cup(random.uniform(0.03, 0.05), random.uniform(0.06, 0.12), 0.002, 40);
    case 6:
      return make_cup(random.uniform(0.05, 0.09), random.uniform(0.04, 0.1), 0.003, 4);
    default:
      return make_blob(random);
  }
}

}  // namespace

Shape make_shape(const TriangleMesh& mesh, double longest_edge) {
  TriangleMesh fine = mesh;
  bool any = true;
  while (any) {
    any = false;
    fine = split_edges(fine, longest_edge, any);
  }
  Shape shape;
  for (const Eigen::Vector3d& vertex : fine.vertices)
    shape.vertices.push_back(vertex.cast<float>());
  shape.triangles = std::move(fine.triangles);
  const auto points = static_cast<std::size_t>(area(mesh) / (kCoverSpacing * kCoverSpacing));
  shape.cover = sample_surface(mesh, points, 1).points;
  measure_sides(shape);
  return shape;
}

Shape distorted(const Shape& model, const ShapeError& error, Seed seed) {
  Shape object = model;
  const WaveField field(0.5 * static_cast<double>(model.sides[0]), seed);
  const auto count = static_cast<Eigen::Index>(model.vertices.size());
  Eigen::Matrix3Xd before(3, count), offset(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    before.col(i) = model.vertices[static_cast<std::size_t>(i)].cast<double>();
    offset.col(i) = field.at(before.col(i));
  }
  const double largest = std::max(offset.colwise().norm().maxCoeff(), 1e-9);
  const Eigen::Matrix3Xd after = before + error.displacement / largest * offset;
  const Eigen::Isometry3d T(Eigen::umeyama(after, before, false));
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3d p = error.scale * (T * after.col(i));
    object.vertices[static_cast<std::size_t>(i)] = p.cast<float>();
  }
  for (Eigen::Vector3f& p : object.cover) p *= static_cast<float>(error.scale);
  measure_sides(object);
  return object;
}

Shape make_unknown(std::span<const Shape> models, Random& random) {
  Shape shape;
  do {
    shape = make_shape(make_random_mesh(random), 0.1);
  } while (resembles(shape, models));
  return shape;
}

Shape make_board(double width, double depth) {
  constexpr std::int32_t kCells = 12;
  TriangleMesh mesh;
  for (std::int32_t j = 0; j <= kCells; ++j) {
    for (std::int32_t i = 0; i <= kCells; ++i) {
      mesh.vertices.emplace_back(width * (i / double{kCells} - 0.5),
                                 depth * (j / double{kCells} - 0.5), 0.0);
      if (i == kCells || j == kCells) continue;
      const std::int32_t a = j * (kCells + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + kCells + 2});
      mesh.triangles.push_back({a, a + kCells + 2, a + kCells + 1});
    }
  }
  Shape shape;
  for (const Eigen::Vector3d& vertex : mesh.vertices)
    shape.vertices.push_back(vertex.cast<float>());
  shape.triangles = std::move(mesh.triangles);
  return shape;
}

Shape make_walls(const Eigen::Vector2d& inside, double height, double thickness) {
  TriangleMesh walls;
  const auto add = [&](const Eigen::Vector3d& size, const Eigen::Vector3d& centre) {
    const TriangleMesh wall = make_box(size);
    const auto first = static_cast<std::int32_t>(walls.vertices.size());
    for (const Eigen::Vector3d& p : wall.vertices) walls.vertices.push_back(centre + p);
    for (const auto& t : wall.triangles) {
      walls.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  };
  const Eigen::Vector2d at = 0.5 * (inside.array() + thickness);
  for (const double side : {-1.0, 1.0}) {
    add({thickness, inside.y() + 2.0 * thickness, height}, {side * at.x(), 0.0, 0.5 * height});
    add({inside.x(), thickness, height}, {0.0, side * at.y(), 0.5 * height});
  }
  return make_shape(walls, 0.1);
}

}  // namespace binpick::testing
