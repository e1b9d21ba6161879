#pragma once

#include <filesystem>
#include <vector>

#include "models/geometry.h"

namespace binpick {

/// Reads a surface from an OBJ or STL file through assimp, or from a PLY file through this room's
/// own reader (assimp's never ends on a PLY header that is cut off). `unit` is the length of the
/// file's unit in metres. Vertices at the same place are made one, degenerate triangles are
/// dropped. assimp runs in a child process with bounded time (0.7 s of processor time, more for
/// files beyond a megabyte) and memory: a file that crashes or hangs it is refused like any other
/// broken one.
/// @throws InputError naming the file: missing, of another kind, unreadable, not finite, or empty.
[[nodiscard]] TriangleMesh import_mesh(const std::filesystem::path& file, double unit = 1.0);

/// As import_mesh for several files, in one child process.
[[nodiscard]] std::vector<TriangleMesh> import_meshes(
    const std::vector<std::filesystem::path>& files, double unit = 1.0);

}  // namespace binpick
