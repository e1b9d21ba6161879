#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "models/robot.h"
#include "sim/elastic_drives.h"
#include "sim/gripper_servo.h"
#include "sim/physics_draw.h"
#include "sim/world_template.h"

namespace binpick {

/// A horizontal elastic plane that one point of the tool presses on, without friction: a contact
/// whose stiffness is known. Force k d (1 + c d_dot) at depth d, never pulling (Hunt and Crossley
/// 1975).
struct CompliantSurface {
  double height = 0.0;                              ///< m
  double stiffness = 30000.0;                       ///< k, N/m
  double dissipation = 0.2;                         ///< c, s/m
  Eigen::Vector3d p_tcp = Eigen::Vector3d::Zero();  ///< the tool's point, tool-centre frame, m
};

/// Everything that determines a world's future, bit for bit.
struct WorldState {
  double time = 0.0;
  std::vector<double> numbers;  ///< MuJoCo's positions, velocities, warm start, inputs, mocap
  GripperServo gripper;
  std::optional<ElasticDrives> drives;
  bool arm_held = false;
  JointVector held_position = JointVector::Zero();
  std::vector<bool> parked;
};

/// The simulated cell: the only place that knows the truth. Steps of 1 ms. Not thread-safe; one
/// world per thread. Results do not depend on the thread or on other worlds.
class World {
 public:
  /// Length of a step, s.
  static constexpr double kStep = 0.001;

  /// Arm held at the scene's overview pose, gripper open. A standing scene has its objects where
  /// the scene says; a pile's objects are parked until they are dropped (pile.h).
  /// Without `drives` the joints are rigid. With elastic joints a step consists of `substeps`
  /// physics steps: one, inside which the motors take a short step per period of their torque
  /// loop, or, as a reference, one or several for each of these periods.
  World(std::shared_ptr<const WorldTemplate> shared, const PhysicsDraw& physics,
        const std::optional<DriveDescription>& drives = std::nullopt, int substeps = 1);

  /// Advances by 1 ms. @throws SimulationDiverged
  void step();
  [[nodiscard]] double time() const noexcept { return data_->time; }  ///< s

  // The arm and its gripper.

  /// Motor torques for the following steps, limited to the joints' efforts. Nm
  void set_arm_torques(const JointVector& tau);
  /// Asked for the motor torques of elastic joints before each period of the torque loop, in place
  /// of set_arm_torques. Rigid joints ignore it.
  void set_torque_loop(std::function<JointVector(const JointState&)> loop) {
    torque_loop_ = std::move(loop);
  }
  void set_gripper_command(const GripperCommand& command) { gripper_.set_command(command); }
  /// Sensor readings without noise. Rigid joints: theta equals q; tau is the torque that the drives
  /// put on the links in the last step, which is what a torque sensor between drive and link reads
  /// when no rotor inertia or friction lies between. Elastic joints: see ElasticDrives.
  [[nodiscard]] RobotState sensors() const;
  /// Puts the arm at `q` and the jaws at `width`, at rest; held arms stay held, there.
  void set_arm_position(const JointVector& q, double width);
  /// Holds the arm where it is (brakes closed) or lets it go. Held joints ignore torques.
  void hold_arm(bool held);
  [[nodiscard]] Eigen::Isometry3d T_world_tcp();
  /// Joint torques that balance gravity and Coriolis forces in this state, tool included. Nm
  [[nodiscard]] JointVector balancing_torques();

  // The truth, for the referee and for setting up.

  [[nodiscard]] int object_count() const noexcept;
  [[nodiscard]] const ObjectModel& object_model(int object) const;
  [[nodiscard]] Eigen::Isometry3d object_pose(int object) const;            ///< T_world_model
  [[nodiscard]] Eigen::Vector3d object_velocity(int object) const;          ///< of the origin, m/s
  [[nodiscard]] Eigen::Vector3d object_angular_velocity(int object) const;  ///< world axes, rad/s
  /// Puts an object there, at rest, and ends its parking.
  void set_object_pose(int object, const Eigen::Isometry3d& T_world_model);
  /// Takes an object out of the cell: it floats far above, out of sight and reach.
  void park_object(int object);
  [[nodiscard]] bool object_parked(int object) const { return parked_[std::size_t(object)]; }
  /// z of the object's lowest surface point, m.
  [[nodiscard]] double object_lowest_point(int object) const;
  /// Normal forces of the left and right jaw (pad and finger) on the object in the last step, N.
  [[nodiscard]] std::array<double, 2> jaw_forces(int object) const;
  /// Whether both jaws press on the object.
  [[nodiscard]] bool object_between_pads(int object) const;
  /// Whether anything but the robot touches the object.
  [[nodiscard]] bool object_supported(int object) const;
  /// Sum of the contact forces on arm and gripper in the last step, surface included, world axes,
  /// N.
  [[nodiscard]] Eigen::Vector3d contact_force_on_robot() const;

  /// Puts a compliant surface into the cell, or takes it out. Not part of the saved state.
  void set_surface(const std::optional<CompliantSurface>& surface) { surface_ = surface; }
  /// What the surface pushes up with in the last physics step, N.
  [[nodiscard]] double surface_force() const noexcept { return surface_force_; }

  /// Puts the pile's frame in place or takes it away. Scenes without a frame ignore it.
  void set_frame_present(bool present);
  /// An outside force at the origin of a body of MuJoCo's, for the following steps, world axes, N.
  void set_body_force(int body, const Eigen::Vector3d& force_world);

  [[nodiscard]] WorldState save_state() const;
  /// Continues bit for bit as the world that saved `state`; same template and physics required.
  void restore_state(const WorldState& state);

  [[nodiscard]] bool elastic() const noexcept { return drives_.has_value(); }
  [[nodiscard]] const WorldTemplate& shared() const noexcept { return *shared_; }
  [[nodiscard]] const std::shared_ptr<const WorldTemplate>& shared_template() const noexcept {
    return shared_;
  }
  [[nodiscard]] const mjModel& model() const noexcept { return *model_; }
  [[nodiscard]] const mjData& data() const noexcept { return *data_; }
  /// For renderers, which MuJoCo wants to hand a mutable world, and for tests.
  [[nodiscard]] mjData& mutable_data() noexcept { return *data_; }
  /// Brings body and geom poses up to date with the positions; step() leaves them one step behind.
  void refresh_poses();

 private:
  void enter_physics(const PhysicsDraw& physics);
  [[nodiscard]] std::optional<double> pair_friction(int pair, const PhysicsDraw& physics) const;
  void place_objects();
  void close_brakes(bool closed);
  void drive_gripper();
  void step_physics();
  void clear_applied_torques();
  void press_surface();
  void step_elastic_arm(int short_steps, bool ask_loop);
  [[nodiscard]] JointVector within_effort(const JointVector& tau) const;
  void pin();
  void pin_arm();
  void pin_object(int object);
  void check_step(double time_before) const;
  template <class Visit>
  void visit_state(Visit visit) const;
  /// Calls visit(geom1, geom2, force in world axes on geom2, contact) for every contact.
  template <class Visit>
  void visit_contacts(Visit visit) const;

  std::shared_ptr<const WorldTemplate> shared_;
  MjModelPtr model_;
  MjDataPtr data_;
  GripperServo gripper_;
  std::optional<ElasticDrives> drives_;
  int substeps_ = 1;
  std::function<JointVector(const JointState&)> torque_loop_;
  std::optional<CompliantSurface> surface_;
  double surface_force_ = 0.0;
  bool arm_held_ = true;
  JointVector held_position_ = JointVector::Zero();
  std::vector<bool> parked_;
};

}  // namespace binpick
