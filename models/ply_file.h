#pragma once

#include "models/input_bytes.h"
#include "models/surface_data.h"

namespace binpick {

/// Reads a PLY file (ASCII, binary of either byte order): vertices, their normals if any, and faces
/// as triangle fans. Other elements and properties are passed over.
/// @throws InputError `file:line:col` in the header and in ASCII, `file: byte N` in binary.
[[nodiscard]] SurfaceData read_ply(InputBytes& in);

}  // namespace binpick
