#pragma once

#include "models/input_bytes.h"
#include "models/surface_data.h"

namespace binpick {

/// Reads a PCD file (version .7; ascii, binary or binary_compressed): x, y, z and, if there,
/// normal_x, normal_y, normal_z. Other fields and the viewpoint are passed over.
/// @throws InputError `file:line:col` in the header and in ASCII, `file: byte N` in binary.
[[nodiscard]] SurfaceData read_pcd(InputBytes& in);

}  // namespace binpick
