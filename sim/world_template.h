#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "models/gripper_description.h"
#include "models/object_model.h"
#include "models/robot_description.h"
#include "scenes/scene.h"
#include "sim/mujoco_handles.h"

namespace binpick {

/// What a world is built from.
struct WorldParts {
  Scene scene;
  RobotDescription arm;
  GripperDescription gripper;
  std::vector<ObjectModel> objects;  ///< one per object of the scene, in its order
};

/// Where the things of a world are found in MuJoCo's arrays.
struct WorldIndex {
  std::array<int, kArmJoints> arm_qpos{};
  std::array<int, kArmJoints> arm_dof{};
  std::array<int, kArmJoints> arm_actuator{};
  std::array<int, 2>
      jaw_qpos{};  ///< left (+y), right (-y); coordinate: pad distance from the centre
  std::array<int, 2> jaw_dof{};
  int jaw_actuator = -1;
  int tcp_site = -1;
  int frame_mocap = -1;                          ///< -1: the scene has no frame
  std::array<std::vector<int>, 2> finger_geoms;  ///< pads and fingers of the left and right jaw
  std::array<int, 2> pad_geom{};
  std::vector<int> object_body;
  std::vector<int> object_qpos;
  std::vector<int> object_dof;
  static constexpr int kCell = -1;
  static constexpr int kRobot = -2;
  /// What each geom belongs to: an object's index, kRobot or kCell.
  std::vector<int> geom_object;
};

/// A compiled cell: shared, immutable, the same for all trials of a scene. Compiling takes tens of
/// milliseconds; a World copies the compiled model and enters its trial's physics. Thread-safe.
struct WorldTemplate {
  WorldParts parts;
  MjModelPtr model;
  WorldIndex index;
};

/// Compiles a cell.
/// @throws InputError when MuJoCo rejects it.
[[nodiscard]] std::shared_ptr<const WorldTemplate> make_world_template(WorldParts parts);

/// Compiles a cell with this repository's arm and gripper and the objects that `scene` names.
/// @throws InputError
[[nodiscard]] std::shared_ptr<const WorldTemplate> make_world_template(const Scene& scene);

}  // namespace binpick
