#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "models/robot.h"

namespace binpick {

/// Inertia of a rigid body, in the frame of its link.
struct BodyInertia {
  double mass = 0.0;                                  ///< kg
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the com, link axes, kg m^2
};

/// A geometric primitive or a mesh file, placed in its link. Cylinders run along z about the
/// origin.
struct LinkShape {
  struct Mesh {
    std::filesystem::path file;
  };
  struct Cylinder {
    double radius;
    double length;
  };
  struct Sphere {
    double radius;
  };
  struct Box {
    Eigen::Vector3d size;
  };
  std::variant<Mesh, Cylinder, Sphere, Box> geometry;
  Eigen::Isometry3d T_link_shape = Eigen::Isometry3d::Identity();
  Eigen::Vector4f colour{0.8f, 0.8f, 0.8f, 1.0f};
};

struct LinkDescription {
  std::string name;
  BodyInertia inertia;
  std::vector<LinkShape> visuals;
  std::vector<LinkShape> collisions;
};

struct JointDescription {
  std::string name;
  Eigen::Isometry3d T_parent_joint = Eigen::Isometry3d::Identity();  ///< at q = 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();                   ///< in the joint frame
  double lower = 0.0;                                                ///< rad
  double upper = 0.0;                                                ///< rad
  double velocity = 0.0;                                             ///< limit, rad/s
  double effort = 0.0;                                               ///< limit, Nm
};

/// The arm: a base and seven links, each behind its joint. links[i] moves with joint i.
struct RobotDescription {
  std::string name;
  LinkDescription base;
  std::array<JointDescription, kArmJoints> joints;
  std::array<LinkDescription, kArmJoints> links;
  Eigen::Isometry3d T_link7_flange = Eigen::Isometry3d::Identity();
};

/// Reads the arm from a URDF: one base, seven revolute joints in a row, a fixed flange.
/// @throws InputError naming file and, where known, line, for anything else.
[[nodiscard]] RobotDescription load_robot_description(const std::filesystem::path& urdf);

/// The arm of this repository, models/lwr/lwr.urdf.
[[nodiscard]] RobotDescription load_lwr();

}  // namespace binpick
