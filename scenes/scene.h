#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "models/cell_layout.h"
#include "models/config_visitor.h"
#include "models/range_image.h"
#include "models/robot.h"

namespace binpick {

/// One inconsistency of a scene: the key it belongs to (empty: the scene as a whole) and why.
struct SceneProblem {
  std::string key;
  std::string message;
};

/// The table top: the plane z = 0 of the world. The extent is what is drawn and what counts as "on
/// the table"; the physics plane has no edge.
struct Table {
  Eigen::Vector2d centre{0.25, 0.0};  ///< m
  Eigen::Vector2d size{1.8, 1.8};     ///< m
  double height = 0.72;               ///< of the top above the floor, m; drawn only

  void visit(ConfigVisitor& visitor);
};

/// A place for objects of some kinds: a box with walls, or (wall height 0) a marked spot on the
/// table.
struct Container {
  std::string name;
  std::vector<std::string> objects;                  ///< the models that belong here
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< m
  Eigen::Vector2d size{0.2, 0.2};                    ///< inside, m
  double wall_height = 0.0;                          ///< m; 0: no walls
  double wall_thickness = 0.02;                      ///< m
  std::vector<Eigen::Vector2d> slots;                ///< targets, used one after the other, m

  [[nodiscard]] bool has_walls() const noexcept { return wall_height > 0.0; }
  void visit(ConfigVisitor& visitor);
};

/// The depth camera: a pinhole with square pixels and its principal point at the image centre.
struct SceneCamera {
  int width = 640;
  int height = 480;
  double focal_length = 575.0;                  ///< px, both axes
  Eigen::Vector3d position{1.064, 0.0, 0.774};  ///< m
  Eigen::Vector3d look_at{0.55, 0.0, 0.0};      ///< a point on the optical axis, m

  [[nodiscard]] CameraIntrinsics intrinsics() const noexcept;
  /// z along the optical axis, x horizontal, y down the image.
  [[nodiscard]] Eigen::Isometry3d T_world_camera() const;
  void visit(ConfigVisitor& visitor);
};

/// How many objects of one model a scene holds.
struct ObjectSet {
  std::string model;
  int count = 1;

  void visit(ConfigVisitor& visitor);
};

/// An object put down by hand: which side is up, where, and turned how far about the vertical.
struct StandingObject {
  std::string model;
  std::string resting =
      "upright";  ///< upright, upside_down, x_up or y_up: the model axis that points up
  Eigen::Vector2d position{0.55, 0.0};  ///< of the model origin, m
  double yaw = 0.0;                     ///< rad

  /// Rotation of the model for `resting` and `yaw`.
  [[nodiscard]] Eigen::Matrix3d R_world_object() const;
  void visit(ConfigVisitor& visitor);
};

/// How a random pile is made: objects fall one after the other into a removable frame.
struct PileRecipe {
  Eigen::Vector2d centre{0.55, 0.0};  ///< m
  double frame_size = 0.40;           ///< inside, m
  double frame_height = 0.40;         ///< m
  double frame_thickness = 0.10;      ///< m; thin walls let fast objects through
  double drop_height = 0.48;          ///< of an object's origin above the table, m
  double drop_interval = 0.5;         ///< s
  double settle_speed = 0.02;         ///< every surface speed below this ... m/s
  double settle_time = 0.2;           ///< ... for this long: the pile rests, s
  double settle_limit = 10.0;         ///< give up this long after the last drop, s

  void visit(ConfigVisitor& visitor);
};

/// What a workcell contains. World frame: origin at the foot of the robot's base on the table top,
/// z up, x towards the pick region.
struct Scene {
  std::string name;     ///< the file's name without its ending
  std::string extends;  ///< a scene file, relative to this one, whose values are the defaults
  Table table;
  std::vector<Container> containers;
  Eigen::Vector2d pick_region_centre{0.55, 0.0};  ///< m
  Eigen::Vector2d pick_region_size{0.5, 0.5};     ///< m
  SceneCamera camera;
  Eigen::Vector3d picture_position{1.75, -1.15, 1.15};  ///< camera for pictures of the cell, m
  Eigen::Vector3d picture_look_at{0.3, 0.02, 0.18};     ///< m
  JointVector overview = JointVector::Zero();           ///< the arm out of the camera's sight, rad
  double transfer_height = 0.30;         ///< tool centre height that clears everything, m
  std::string arrangement = "standing";  ///< standing or pile
  std::vector<ObjectSet> objects;        ///< of a pile, in no order
  std::vector<StandingObject> standing;  ///< of a standing arrangement
  PileRecipe pile;

  /// Model names, one per object: of `objects` or `standing`, whichever the arrangement says.
  [[nodiscard]] std::vector<std::string> object_names() const;
  /// Every inconsistency between values that are fine one by one.
  [[nodiscard]] std::vector<SceneProblem> validate() const;
  void visit(ConfigVisitor& visitor);
};

/// Reads a scene file and the files it extends.
/// @throws InputError with one line `file:line:col: message` per problem.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file);

/// `file` and the files that it extends, in this order.
/// @throws InputError as load_scene.
[[nodiscard]] std::vector<std::filesystem::path> scene_files(const std::filesystem::path& file);

/// What the robot's integrator would enter by hand about this cell.
[[nodiscard]] CellLayout cell_layout(const Scene& scene);

}  // namespace binpick
