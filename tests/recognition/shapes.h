#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "models/geometry.h"
#include "recognition/model_library.h"

namespace binpick::testing {

/// A box about the origin, outward triangles.
TriangleMesh make_box(const Eigen::Vector3d& size);

/// A prism or, with many sides, a cylinder along z about the origin; `radius` to the corners.
TriangleMesh make_prism(int sides, double radius, double height);

TriangleMesh make_sphere(double radius);

/// The repository's three objects (models/objects) with their symmetries: bottle, amicelli, rusk.
std::vector<ModelSource> known_objects();

}  // namespace binpick::testing
