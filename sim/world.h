#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "models/robot.h"
#include "sim/gripper_servo.h"
#include "sim/physics_draw.h"
#include "sim/world_template.h"

namespace binpick {

/// Everything that determines a world's future, bit for bit.
struct WorldState {
  double time = 0.0;
  std::vector<double> numbers;  ///< MuJoCo's positions, velocities, warm start, controls, mocap
  GripperServo gripper;
  bool arm_held = false;
  JointVector held_position = JointVector::Zero();
};

/// The simulated cell: the only place that knows the truth. Steps of 1 ms. Not thread-safe; one
/// world per thread. Results do not depend on the thread or on other worlds.
class World {
 public:
  /// Arm at the scene's overview pose and held there, gripper open, objects parked at their
  /// standing poses (standing arrangement) or out of the way (pile).
  World(std::shared_ptr<const WorldTemplate> shared, const PhysicsDraw& physics);

  /// Advances by 1 ms. @throws SimulationDiverged
  void step();
  [[nodiscard]] double time() const noexcept { return data_->time; }  ///< s

  // The arm and its gripper.
  /// Joint torques for the following steps, limited to the joints' efforts. Nm
  void set_arm_torques(const JointVector& tau);
  void set_gripper_command(const GripperCommand& command) { gripper_.set_command(command); }
  /// Sensor readings without noise. Rigid joints: theta equals q; tau is what the drives put on the
  /// links in the last step.
  [[nodiscard]] RobotState sensors() const;
  /// Puts the arm at `q` and the jaws at `width`, at rest.
  void set_arm_position(const JointVector& q, double width);
  /// Holds the arm where it is (brakes closed) or lets it go. Held joints ignore torques.
  void hold_arm(bool held);
  [[nodiscard]] Eigen::Isometry3d T_world_tcp() const;

  // The truth, for the referee and for setting up.
  [[nodiscard]] int object_count() const noexcept;
  [[nodiscard]] const ObjectModel& object_model(int object) const;
  [[nodiscard]] Eigen::Isometry3d object_pose(int object) const;            ///< T_world_model
  [[nodiscard]] Eigen::Vector3d object_velocity(int object) const;          ///< of the origin, m/s
  [[nodiscard]] Eigen::Vector3d object_angular_velocity(int object) const;  ///< world axes, rad/s
  /// Moves an object there, at rest.
  void set_object_pose(int object, const Eigen::Isometry3d& T_world_model);
  /// z of the object's lowest vertex, m.
  [[nodiscard]] double object_lowest_point(int object) const;
  /// Whether both pads (or fingers) touch the object with a force.
  [[nodiscard]] bool object_between_pads(int object) const;
  /// Normal force of the left and right jaw on the object, N.
  [[nodiscard]] std::array<double, 2> jaw_forces(int object) const;
  /// Sum of the contact forces that the cell exerts on arm and gripper (objects included), N,
  /// world.
  [[nodiscard]] Eigen::Vector3d contact_force_on_robot() const;
  /// The objects that touch table, bins or other objects rather than hang free.
  [[nodiscard]] bool object_supported(int object) const;

  /// Removes the pile's frame or puts it back.
  void set_frame_present(bool present);

  /// An outside force at the tool centre for the following steps, world axes, N. For tests.
  void set_tool_force(const Eigen::Vector3d& force_world);

  [[nodiscard]] WorldState save_state() const;
  /// Continues bit for bit as the world that saved `state`; same template and physics required.
  void restore_state(const WorldState& state);

  [[nodiscard]] const WorldTemplate& shared() const noexcept { return *shared_; }
  [[nodiscard]] const mjModel& model() const noexcept { return *model_; }
  [[nodiscard]] const mjData& data() const noexcept { return *data_; }
  /// For renderers, which MuJoCo wants to hand a mutable world, and for tests.
  [[nodiscard]] mjData& mutable_data() noexcept { return *data_; }

 private:
  void enter_physics(const PhysicsDraw& physics);
  void place_objects();
  void pin_arm();
  void check_step(double time_before) const;

  std::shared_ptr<const WorldTemplate> shared_;
  MjModelPtr model_;
  MjDataPtr data_;
  GripperServo gripper_;
  bool arm_held_ = true;
  JointVector held_position_ = JointVector::Zero();
};

}  // namespace binpick
