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

/// Projects `cloud`, seen from about `viewpoint`. The pixels of an organised cloud are kept if they
/// fit a pinhole camera whose axes are the cloud's: at the viewpoint, or else where they say that
/// it is. Otherwise the camera looks from the viewpoint at the middle of the points, with a focal
/// length at which an occupied pixel holds about two points; of several points in one pixel the
/// nearest count, and what is seen between the points of a nearer surface does not: a cloud of a
/// whole body shows the side towards the viewpoint. A cloud without finite points gives an image of
/// size zero. O(points), on up to `jobs` threads; the same for any number.
[[nodiscard]] ProjectedCloud project_cloud(const PointCloud& cloud,
                                           const Eigen::Vector3d& viewpoint, int jobs = 1);

}  // namespace binpick
