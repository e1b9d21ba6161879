#pragma once

#include <filesystem>
#include <string>

namespace binpick {

/// The file that a description names relative to its own folder. Absolute names, URIs and names
/// that lead out of the folder are refused, links included.
/// @throws InputError (without a position, which the caller knows) for those and for a missing
/// file.
[[nodiscard]] std::filesystem::path resolve_inside(const std::filesystem::path& directory,
                                                   const std::string& name);

}  // namespace binpick
