#pragma once

#include <Eigen/Geometry>

#include "control/operational_space.h"
#include "models/robot.h"

namespace binpick {

/// Where the joints should be and how they should move: a point of a joint trajectory, and what
/// joint impedance follows.
struct JointTarget {
  JointVector q = JointVector::Zero();    ///< rad
  JointVector qd = JointVector::Zero();   ///< rad/s
  JointVector qdd = JointVector::Zero();  ///< rad/s^2
};

/// Where the tool centre should be and how it should move; world axes: a point of a Cartesian
/// trajectory, and what Cartesian impedance follows.
struct CartesianTarget {
  Eigen::Isometry3d T_world_tcp = Eigen::Isometry3d::Identity();
  Vector6 twist = Vector6::Zero();         ///< m/s, rad/s; of the tool centre
  Vector6 acceleration = Vector6::Zero();  ///< m/s^2, rad/s^2
};

}  // namespace binpick
