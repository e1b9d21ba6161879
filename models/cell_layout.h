#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "models/robot.h"

namespace binpick {

/// Where objects of one kind are brought.
struct Place {
  std::string name;                                   ///< e.g. "bottle bin"
  std::vector<std::string> objects;                   ///< the models that belong here
  Eigen::Vector2d p_world = Eigen::Vector2d::Zero();  ///< centre of the place, m
  /// Where the tool centre goes for the first, second, ... object, starting again after the last;
  /// never empty. Objects are lowered there until contact.
  std::vector<Eigen::Vector2d> slots;
  Eigen::Vector2d size = Eigen::Vector2d::Zero();  ///< extent in x and y, m
  double floor_height = 0.0;                       ///< z of the supporting surface, m
  double rim_height = 0.0;                         ///< z that must be cleared on the way, m
};

/// The fixed layout of the cell: what a robot's integrator would enter by hand. World frame: origin
/// at the foot of the robot's base, z up, normal to the table.
struct CellLayout {
  double table_height = 0.0;        ///< z of the table top, m
  Eigen::AlignedBox2d pick_region;  ///< detections outside are ignored
  std::vector<Place> places;
  Eigen::Isometry3d T_world_base = Eigen::Isometry3d::Identity();
  JointVector overview = JointVector::Zero();  ///< arm out of the camera's sight, rad
  double transfer_height = 0.0;                ///< tool height that clears everything, m
};

}  // namespace binpick
