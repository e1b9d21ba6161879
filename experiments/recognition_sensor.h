#pragma once

#include <variant>

#include "experiments/recognition_conditions.h"
#include "models/geometry.h"
#include "models/random.h"
#include "models/range_image.h"
#include "sim/renderer.h"

namespace binpick {

/// What a sensor delivers: a range image, or a cloud in the camera's frame, seen from its origin.
using Scan = std::variant<RangeImage, PointCloud>;

/// What the sensor of `conditions` makes of an ideal range image. For the sensor "gaussian" every
/// coordinate of every point gets normal noise of `gaussian` times `diagonal`, m.
[[nodiscard]] Scan measure(const RangeImage& ideal, const RecognitionConditions& conditions,
                           double diagonal, Seed seed);

/// What the sensor could measure at all: the ideal image without the points that its light, thrown
/// from beside the camera, does not reach.
[[nodiscard]] RangeImage lit(const RangeImage& ideal, const RecognitionConditions& conditions);

/// Grows nearer surfaces over the edges of farther ones by `pixels` (Chebyshev distance), as the
/// correlation windows of structured-light sensors do.
void dilate_silhouettes(RangeImage& image, int pixels);

/// The point of pixel i under the sensor "gaussian", m, camera frame.
[[nodiscard]] Eigen::Vector3d gaussian_point(const RangeImage& ideal, std::size_t i, double sigma,
                                             Seed seed);

/// Takes away what was measured where the ideal image shows no object.
void keep_objects_only(RangeImage& scan, const SegmentationImage& owners);

/// Number of points of a scan that were measured.
[[nodiscard]] std::size_t point_count(const Scan& scan);

}  // namespace binpick
