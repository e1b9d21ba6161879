#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "models/random.h"

namespace binpick {

/// A plane on which (or in front of which) the objects are, e.g. a table: normal . p = offset, the
/// normal pointing to the side of the sensor.
struct SupportPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;
  double tolerance = 0.0;  ///< points up to this height belong to the plane, m

  /// Height above the plane, m.
  [[nodiscard]] double height(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

}  // namespace binpick
