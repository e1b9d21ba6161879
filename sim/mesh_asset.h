#pragma once

#include <Eigen/Core>
#include <vector>

#include "models/geometry.h"

namespace binpick {

/// Bytes of MuJoCo's binary mesh format (MSH). With `shaded`, corners get normals of their own
/// where faces meet at more than 40 degrees, so that edges look sharp and curves smooth.
[[nodiscard]] std::vector<char> to_msh(const TriangleMesh& mesh, bool shaded);

/// The vertices of the convex hull of `meshes` that can touch a plane: those that lie furthest
/// along one of 2000 directions, thinned out to `spacing`, or three times that in the flat faces
/// across the model's axes, where few points carry as well as many.
[[nodiscard]] std::vector<Eigen::Vector3d> support_points(const std::vector<TriangleMesh>& meshes,
                                                          double spacing);

/// The prism over a convex polygon in the y-z plane, along x from -width/2 to width/2.
[[nodiscard]] TriangleMesh prism(const std::vector<Eigen::Vector2d>& polygon_yz, double width);

/// The box of the given size about `centre`.
[[nodiscard]] TriangleMesh box_mesh(const Eigen::Vector3d& size, const Eigen::Vector3d& centre);

}  // namespace binpick
