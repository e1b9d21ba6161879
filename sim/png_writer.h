#pragma once

#include <filesystem>

#include "models/range_image.h"
#include "sim/renderer.h"

namespace binpick {

/// @throws IoError when the file cannot be written; nothing is left behind then.
void write_png(const std::filesystem::path& file, const ColourImage& image);

/// 16-bit grey, millimetres, 0 where nothing was measured.
void write_depth_png(const std::filesystem::path& file, const RangeImage& image);

/// Near is warm, far is cold, black where nothing was measured; scaled to the image's range.
[[nodiscard]] ColourImage false_colour(const RangeImage& image);

/// One colour per object; robot and cell in greys.
[[nodiscard]] ColourImage false_colour(const SegmentationImage& image);

}  // namespace binpick
