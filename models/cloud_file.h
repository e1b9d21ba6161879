#pragma once

#include <filesystem>

#include "models/geometry.h"

namespace binpick {

/// Reads points and, if there, normals from a PLY, PCD or legacy VTK file, told apart by their
/// first line. `unit` is the length of the file's unit in metres. Faces are left out. Unit normals;
/// what was not measured is NaN in an organised cloud and left out of any other.
/// @throws InputError `file:line:col` in text and `file: byte N` in binary parts; IoError.
[[nodiscard]] PointCloud read_cloud(const std::filesystem::path& file, double unit = 1.0);

/// Writes a binary little-endian PLY in metres, with normals if the cloud has them. Points that
/// were not measured are left out. @throws IoError.
void write_ply(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace binpick
