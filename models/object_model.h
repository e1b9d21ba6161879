#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "models/geometry.h"

namespace binpick {

/// A stored grasp G (IJRR 2012, section 5.1): the pose of the tool centre relative to the object.
/// z of the grasp frame is the approach vector v_appr, y the axis along which the jaws move.
struct Grasp {
  std::string name;
  Eigen::Isometry3d T_object_grasp = Eigen::Isometry3d::Identity();
  double pre_opening = 0.0;     ///< jaw distance while approaching, m
  double expected_width = 0.0;  ///< jaw distance when the object is held, m
};

/// What an object weighs and how it slides. Ranges come from independent sources, named in the
/// description file; experiments draw from them per trial or hold them at their centres.
struct ObjectPhysics {
  Interval mass;             ///< kg
  Interval table_friction;   ///< Coulomb coefficient against table and bins
  Interval object_friction;  ///< against other objects
  Interval pad_friction;     ///< against the gripper's rubber pads
  /// Centre of mass and inertia per kilogram about it, axes of the model frame; from the mesh.
  Eigen::Vector3d p_model_com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_per_mass = Eigen::Matrix3d::Identity();
};

/// A known object: what the recognizer searches, the world simulates and the gripper grasps.
/// Model frame: origin at the centre of the bounding box, z up when the object stands.
struct ObjectModel {
  std::string name;
  TriangleMesh mesh;                    ///< the surface: rendered and recognized
  std::vector<TriangleMesh> collision;  ///< convex pieces
  Eigen::Vector4f colour{0.7f, 0.7f, 0.7f, 1.0f};
  ObjectPhysics physics;
  /// The poses that cannot be told apart by shape, identity first: T_model_equivalent.
  std::vector<Eigen::Isometry3d> symmetries;
  std::vector<Grasp> grasps;
};

/// Reads `directory`/object.yaml and the meshes it names.
/// @throws InputError with file:line:col for anything missing, malformed or unphysical.
[[nodiscard]] ObjectModel load_object_model(const std::filesystem::path& directory);

/// Reads the built-in object `name` (a folder of models/objects).
[[nodiscard]] ObjectModel load_known_object(const std::string& name);

/// The folder of the repository's models: $BINPICK_MODELS if set, else the source tree's.
[[nodiscard]] std::filesystem::path models_directory();

}  // namespace binpick
