#include "sim/mesh_asset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace binpick {
namespace {

const double kSharpCosine = std::cos(40.0 * M_PI / 180.0);

struct ShadedMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

template <class Value>
void append(std::vector<char>& bytes, const Value& value) {
  const std::size_t end = bytes.size();
  bytes.resize(end + sizeof(Value));
  std::memcpy(bytes.data() + end, &value, sizeof(Value));
}

// Twice the area times the normal.
Eigen::Vector3d area_normal(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& triangle) {
  const Eigen::Vector3d& a = mesh.vertices[std::size_t(triangle[0])];
  const Eigen::Vector3d& b = mesh.vertices[std::size_t(triangle[1])];
  const Eigen::Vector3d& c = mesh.vertices[std::size_t(triangle[2])];
  return (b - a).cross(c - a);
}

// Every corner gets the mean normal of the faces around its position that do not bend away sharply.
ShadedMesh with_corner_normals(const TriangleMesh& mesh) {
  struct ByCoordinates {
    bool operator()(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    }
  };
  std::map<Eigen::Vector3d, std::vector<std::size_t>, ByCoordinates> faces_at;
  std::vector<Eigen::Vector3d> face_normals;
  for (std::size_t face = 0; face < mesh.triangles.size(); ++face) {
    face_normals.push_back(area_normal(mesh, mesh.triangles[face]));
    for (const std::int32_t vertex : mesh.triangles[face]) {
      faces_at[mesh.vertices[std::size_t(vertex)]].push_back(face);
    }
  }
  ShadedMesh shaded;
  for (std::size_t face = 0; face < mesh.triangles.size(); ++face) {
    const Eigen::Vector3d own = face_normals[face].normalized();
    if (face_normals[face].norm() < 1e-14) continue;
    std::array<std::int32_t, 3> corners{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3d& position = mesh.vertices[std::size_t(mesh.triangles[face][corner])];
      Eigen::Vector3d normal = Eigen::Vector3d::Zero();
      for (const std::size_t neighbour : faces_at[position]) {
        if (face_normals[neighbour].normalized().dot(own) > kSharpCosine) {
          normal += face_normals[neighbour];
        }
      }
      corners[corner] = static_cast<std::int32_t>(shaded.vertices.size());
      shaded.vertices.push_back(position.cast<float>());
      shaded.normals.push_back(normal.normalized().cast<float>());
    }
    shaded.triangles.push_back(corners);
  }
  return shaded;
}

std::array<Eigen::Vector3d, 6> axis_directions() {
  std::array<Eigen::Vector3d, 6> directions;
  for (int axis = 0; axis < 3; ++axis) {
    directions[std::size_t(2 * axis)] = -Eigen::Vector3d::Unit(axis);
    directions[std::size_t(2 * axis + 1)] = Eigen::Vector3d::Unit(axis);
  }
  return directions;
}

std::vector<Eigen::Vector3d> spiral_directions(int count) {
  std::vector<Eigen::Vector3d> directions;
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count;
    const double radius = std::sqrt(1.0 - z * z);
    directions.emplace_back(radius * std::cos(golden * i), radius * std::sin(golden * i), z);
  }
  return directions;
}

using Points = std::vector<Eigen::Vector3d>;

// The points that a plane coming from `direction` touches first, all within 10 um together.
Points touched_first(const Points& points, const Eigen::Vector3d& direction) {
  constexpr double kTogether = 1e-5;
  double furthest = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& point : points) furthest = std::max(furthest, point.dot(direction));
  Points touched;
  for (const Eigen::Vector3d& point : points) {
    if (point.dot(direction) > furthest - kTogether) touched.push_back(point);
  }
  return touched;
}

bool any_within(const Points& points, const Eigen::Vector3d& centre, double distance) {
  return std::any_of(points.begin(), points.end(), [&](const Eigen::Vector3d& point) {
    return (point - centre).norm() < distance;
  });
}

}  // namespace

std::vector<char> to_msh(const TriangleMesh& mesh, bool shaded) {
  ShadedMesh out;
  if (shaded) {
    out = with_corner_normals(mesh);
  } else {
    for (const Eigen::Vector3d& vertex : mesh.vertices)
      out.vertices.push_back(vertex.cast<float>());
    out.triangles = mesh.triangles;
  }
  std::vector<char> bytes;
  append(bytes, static_cast<std::int32_t>(out.vertices.size()));
  append(bytes, static_cast<std::int32_t>(out.normals.size()));
  append(bytes, std::int32_t{0});
  append(bytes, static_cast<std::int32_t>(out.triangles.size()));
  for (const auto* vectors : {&out.vertices, &out.normals}) {
    for (const Eigen::Vector3f& vector : *vectors) {
      for (int axis = 0; axis < 3; ++axis) append(bytes, vector[axis]);
    }
  }
  for (const std::array<std::int32_t, 3>& triangle : out.triangles) append(bytes, triangle);
  return bytes;
}

std::vector<Eigen::Vector3d> support_points(const std::vector<TriangleMesh>& meshes,
                                            double spacing) {
  Points vertices;
  for (const TriangleMesh& mesh : meshes) {
    vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  }
  Points chosen;
  Points in_flat_faces;
  const auto add = [&](const Points& points, double distance) {
    for (const Eigen::Vector3d& point : points) {
      if (!any_within(chosen, point, distance)) chosen.push_back(point);
    }
  };
  for (const Eigen::Vector3d& across : axis_directions()) {
    const Points face = touched_first(vertices, across);
    in_flat_faces.insert(in_flat_faces.end(), face.begin(), face.end());
    // The face's own extremes carry when the object lies on its side.
    for (const Eigen::Vector3d& along : axis_directions()) {
      if (along.dot(across) == 0.0) add(touched_first(face, along), spacing);
    }
    add(face, 4.0 * spacing);
  }
  for (const Eigen::Vector3d& direction : spiral_directions(2000)) {
    for (const Eigen::Vector3d& vertex : touched_first(vertices, direction)) {
      if (!any_within(chosen, vertex, spacing) && !any_within(in_flat_faces, vertex, 1e-9)) {
        chosen.push_back(vertex);
      }
    }
  }
  return chosen;
}

TriangleMesh prism(const std::vector<Eigen::Vector2d>& polygon_yz, double width) {
  TriangleMesh mesh;
  const auto corners = static_cast<std::int32_t>(polygon_yz.size());
  for (const double x : {-0.5 * width, 0.5 * width}) {
    for (const Eigen::Vector2d& corner : polygon_yz) {
      mesh.vertices.emplace_back(x, corner.x(), corner.y());
    }
  }
  const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    mesh.triangles.push_back({a, b, c});
  };
  for (std::int32_t i = 0; i < corners; ++i) {
    const std::int32_t next = (i + 1) % corners;
    add(i, next, next + corners);
    add(i, next + corners, i + corners);
    if (i >= 1 && i + 1 < corners) {
      add(0, i + 1, i);
      add(corners, corners + i, corners + i + 1);
    }
  }
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& vertex : mesh.vertices) centre += vertex;
  centre /= static_cast<double>(mesh.vertices.size());
  // Convex: a face looks outward when it looks away from the centre.
  for (std::array<std::int32_t, 3>& triangle : mesh.triangles) {
    const Eigen::Vector3d& corner = mesh.vertices[std::size_t(triangle[0])];
    if (area_normal(mesh, triangle).dot(corner - centre) < 0.0) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

TriangleMesh box_mesh(const Eigen::Vector3d& size, const Eigen::Vector3d& centre) {
  const double y = 0.5 * size.y();
  const double z = 0.5 * size.z();
  TriangleMesh mesh = prism({{-y, -z}, {y, -z}, {y, z}, {-y, z}}, size.x());
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex += centre;
  return mesh;
}

}  // namespace binpick
