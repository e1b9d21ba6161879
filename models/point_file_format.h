#pragma once

#include <filesystem>

#include "models/surface_data.h"

namespace binpick {

/// Reads a PLY, PCD or legacy VTK file, told apart by their first line.
/// @throws InputError, IoError.
[[nodiscard]] SurfaceData read_point_file(const std::filesystem::path& file);

}  // namespace binpick
