#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "models/geometry.h"
#include "recognition/pair_descriptor.h"

namespace binpick {

/// `count` points spread evenly over the surface by area, with the triangles' normals.
/// Deterministic (a low-discrepancy sequence). Degenerate triangles get none.
[[nodiscard]] std::vector<OrientedPoint> sample_evenly(const TriangleMesh& mesh, std::size_t count);

/// Total area of the triangles, m^2.
[[nodiscard]] double surface_area(const TriangleMesh& mesh);

/// A subset in which no two points of like orientation are closer than `spacing`, covering the
/// rest: first come, first kept, in expected linear time.
[[nodiscard]] std::vector<OrientedPoint> thin_out(const std::vector<OrientedPoint>& points,
                                                  float spacing);

/// At most `count` points by farthest-point sampling, reordered so that every prefix covers the
/// whole uniformly. O(points x count).
[[nodiscard]] std::vector<OrientedPoint> spread_evenly(const std::vector<OrientedPoint>& points,
                                                       std::size_t count);

/// PCA normals of a cloud from the points within `radius`, oriented so that they point towards
/// `towards` (a sensor) or, if `outward`, away from it (a centre).
[[nodiscard]] std::vector<Eigen::Vector3f> estimate_normals(
    const std::vector<Eigen::Vector3f>& points, float radius, const Eigen::Vector3f& towards,
    bool outward);

}  // namespace binpick
