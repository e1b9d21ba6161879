#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "recognition/pair_descriptor.h"

namespace binpick {

/// The rotations (with the translations that go with them) that map a surface onto itself, found by
/// registering it with itself; the identity first. They form a group.
///
/// Every symmetry fixes the centroid and the ellipsoid of inertia, so the axes that can carry one
/// are few: three axes when the moments of inertia differ, one axis and those across it when two
/// are equal, any when all are. Each candidate is aligned by point-to-plane least squares and taken
/// when no point of the turned surface is farther than 0.5 % of the diameter from the surface. A
/// continuous symmetry is given in steps of 10 degrees, that of a sphere as the 60 rotations of the
/// icosahedron (radii that differ by less than 1.5 % of the diameter).
///
/// `surface` must be dense (spacing of some 2 % of `diameter`) and even; `samples` is what is
/// turned and compared. Some milliseconds. Deterministic.
[[nodiscard]] std::vector<Eigen::Isometry3d> find_symmetries(
    const std::vector<OrientedPoint>& surface, const std::vector<OrientedPoint>& samples,
    float diameter);

}  // namespace binpick
