#pragma once

#include "models/geometry.h"

namespace binpick {

/// The same surface in fewer triangles: edges are collapsed, cheapest first, as long as the new
/// vertex lies within `tolerance` (root mean square, by area) of the planes of all triangles that
/// it stands for. Keeps the topology and, within the tolerance, borders and creases. Garland and
/// Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997.
/// O(n log n); deterministic.
[[nodiscard]] TriangleMesh simplify(const TriangleMesh& mesh, double tolerance);

}  // namespace binpick
