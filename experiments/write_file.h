#pragma once

#include <filesystem>
#include <string_view>

namespace binpick {

/// Replaces `file` by one with this content, all or nothing: whoever reads meanwhile, or after a
/// crash, sees the old content or the new.
/// @throws IoError.
void write_file(const std::filesystem::path& file, std::string_view content);

/// Makes `folder` and its parents.
/// @throws IoError.
void make_folder(const std::filesystem::path& folder);

}  // namespace binpick
