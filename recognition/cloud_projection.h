#pragma once

#include <Eigen/Geometry>

#include "models/geometry.h"
#include "models/range_image.h"

namespace binpick {

/// A cloud as the range image that its sensor saw.
struct ProjectedCloud {
  RangeImage image;
  Eigen::Isometry3d T_cloud_camera = Eigen::Isometry3d::Identity();
};

/// Projects `cloud`, seen from `viewpoint`. The pixels of an organised cloud that fits a pinhole
/// camera at the viewpoint are kept. Otherwise the camera looks at the middle of the points, with a
/// focal length at which an occupied pixel holds about two points; of several points in one pixel
/// the nearest count. A cloud without finite points gives an image of size zero. O(points).
[[nodiscard]] ProjectedCloud project_cloud(const PointCloud& cloud,
                                           const Eigen::Vector3d& viewpoint);

}  // namespace binpick
