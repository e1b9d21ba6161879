#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "models/object_model.h"

namespace binpick {

/// An object of a recognition experiment by its name: a product (a folder of models/objects), a
/// free-form toy (a mesh of models/toys), or one of the foreign objects "can" (66 x 115 mm) and
/// "carton" (70 x 70 x 195 mm). Toys and foreign objects have no grasps; toys collide as the convex
/// hulls of six patches of their surface. Read once per process and kept: an experiment asks for
/// the same few objects in every cell.
/// @throws InputError for an unknown name.
[[nodiscard]] const ObjectModel& recognition_object(const std::string& name);

/// The meshes of all toys, sorted.
[[nodiscard]] std::vector<std::filesystem::path> toy_files();

}  // namespace binpick
