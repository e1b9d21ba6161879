#pragma once

#include "models/input_bytes.h"
#include "models/surface_data.h"

namespace binpick {

/// Reads a legacy VTK file with a POLYDATA set (ASCII or binary): points, the normals at the points
/// if any, polygons and triangle strips as triangles. Other data are passed over.
/// @throws InputError `file:line:col` in text, `file: byte N` in binary parts.
[[nodiscard]] SurfaceData read_vtk(InputBytes& in);

}  // namespace binpick
