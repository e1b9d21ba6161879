#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "models/geometry.h"
#include "models/random.h"

namespace binpick {

/// Mass properties per kilogram. Axes and origin of the mesh.
struct MassProperties {
  double extent = 0.0;  ///< what the mass is spread over: volume in m^3, or area in m^2
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the com, for 1 kg
};

[[nodiscard]] double area(const TriangleMesh& mesh);
/// Enclosed volume by the divergence theorem; negative when the triangles face inward.
[[nodiscard]] double volume(const TriangleMesh& mesh);
/// Of a homogeneous solid: sums of signed tetrahedra. Needs a closed surface.
[[nodiscard]] MassProperties solid_properties(const TriangleMesh& mesh);
/// Of an even thin shell.
[[nodiscard]] MassProperties shell_properties(const TriangleMesh& mesh);

[[nodiscard]] Eigen::AlignedBox3d bounding_box(const TriangleMesh& mesh);
/// The diagonal of the bounding box, the usual stand-in for a model's diameter.
[[nodiscard]] double bounding_diagonal(const TriangleMesh& mesh);

/// z of the lowest vertex of the mesh placed at `T_world_mesh`; infinity without vertices.
[[nodiscard]] double lowest_point(const Eigen::Isometry3d& T_world_mesh, const TriangleMesh& mesh);

/// Every edge is shared by exactly two triangles that run through it in opposite directions.
[[nodiscard]] bool is_watertight(const TriangleMesh& mesh);

/// `count` points, uniform by area, with the outward normals of their triangles. The same seed
/// gives the same points.
[[nodiscard]] PointCloud sample_surface(const TriangleMesh& mesh, std::size_t count, Seed seed);

}  // namespace binpick
