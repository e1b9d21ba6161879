#pragma once

#include <filesystem>
#include <span>

#include "models/detection.h"
#include "recognition/recognition_score.h"
#include "recognition/synthetic_scene.h"

namespace binpick::testing {

/// Writes the frame, lit from the camera, as PNG with silhouettes: found objects green, missed ones
/// red (orange when they show less than 30 % or leave the image), false detections magenta, right
/// ones white where they deviate from the truth. @throws IoError.
void write_picture(const std::filesystem::path& file, const SyntheticFrame& frame,
                   std::span<const Detection> detections, const FrameScore& score,
                   std::span<const ModelSource> models);

}  // namespace binpick::testing
