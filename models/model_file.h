#pragma once

#include <filesystem>
#include <variant>

#include "models/geometry.h"

namespace binpick {

/// A surface or bare points.
using ModelGeometry = std::variant<TriangleMesh, PointCloud>;

/// Reads whatever a person has of an object or a scene: OBJ, STL, and PLY or legacy VTK with faces
/// as a mesh; PLY and VTK without faces and PCD as a cloud. `unit` is the length of the file's unit
/// in metres.
/// @throws InputError, IoError.
[[nodiscard]] ModelGeometry read_model_file(const std::filesystem::path& file, double unit = 1.0);

}  // namespace binpick
