#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "models/detection.h"
#include "models/geometry.h"
#include "recognition/model_library.h"
#include "sim/renderer.h"

namespace binpick {

/// The scan as its sensor saw it, near bright and far dark, black where nothing was measured, with
/// the outline of every detection drawn over it: one colour per model. Empty for a scan without
/// points. `viewpoint` is the sensor's place in the scan's frame.
[[nodiscard]] ColourImage detection_picture(const PointCloud& scan,
                                            const Eigen::Vector3d& viewpoint,
                                            const std::vector<Detection>& detections,
                                            const ModelLibrary& library);

}  // namespace binpick
