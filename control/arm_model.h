#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "models/gripper_description.h"
#include "models/robot_description.h"

namespace binpick {

using JointMatrix = Eigen::Matrix<double, kArmJoints, kArmJoints>;
/// Rows 0-2: linear velocity of the tool centre; rows 3-5: angular velocity. World axes.
using Jacobian = Eigen::Matrix<double, 6, kArmJoints>;
/// Linear velocity of a point, world axes.
using PointJacobian = Eigen::Matrix<double, 3, kArmJoints>;

/// What each joint can do; SI units.
struct JointLimits {
  JointVector lower = JointVector::Zero();     ///< rad
  JointVector upper = JointVector::Zero();     ///< rad
  JointVector velocity = JointVector::Zero();  ///< rad/s
  JointVector effort = JointVector::Zero();    ///< Nm

  [[nodiscard]] bool contains(const JointVector& q) const noexcept {
    return (q.array() >= lower.array()).all() && (q.array() <= upper.array()).all();
  }
};

/// Everything that a controller needs at one state (q, qd):
/// M(q) qdd + C(q, qd) qd + g(q) = tau + J^T F_ext.
struct ArmDynamics {
  JointMatrix M;                    ///< joint-space inertia, kg m^2; no rotor inertia
  JointVector coriolis;             ///< C(q, qd) qd, Nm
  JointVector coriolis_transposed;  ///< C(q, qd)^T qd = M_dot qd - C qd, Nm (momentum observer)
  JointVector gravity;              ///< g(q), Nm: the torque that holds the arm still
  Jacobian J;                       ///< of the tool centre
  Jacobian J_dot;                   ///< its time derivative at qd
  Eigen::Isometry3d T_world_tcp;
};

/// A point of the arm and how the joints move it.
struct PointKinematics {
  Eigen::Vector3d p_world;
  PointJacobian J;
};

/// Rigid-body model of the arm with the gripper as a fixed tool. Built from the descriptions (the
/// URDF), never from the simulated world. Immutable: safe to share between threads.
class ArmModel {
 public:
  /// The gripper is carried as one rigid body, its jaws at the middle of their stroke.
  /// @throws InputError if masses, inertias, axes or limits are not physical.
  ArmModel(const RobotDescription& robot, const GripperDescription& gripper,
           const Eigen::Isometry3d& T_world_base = Eigen::Isometry3d::Identity());

  /// One pass outward and one inward over the links with spatial vectors in world axes about the
  /// base origin: composite rigid bodies for M, Newton-Euler for C qd (Featherstone 2008,
  /// algorithms 5.1 and 6.2). Allocates nothing.
  [[nodiscard]] ArmDynamics evaluate(const JointVector& q, const JointVector& qd) const noexcept;

  /// T_world_tcp.
  [[nodiscard]] Eigen::Isometry3d forward_kinematics(const JointVector& q) const noexcept;
  /// T_world_link of the base (0) and of links 1 to 7.
  [[nodiscard]] std::array<Eigen::Isometry3d, kArmJoints + 1> link_poses(
      const JointVector& q) const noexcept;
  [[nodiscard]] Jacobian jacobian(const JointVector& q) const noexcept;
  /// g(q), Nm; gravity acts along -z of the world.
  [[nodiscard]] JointVector gravity(const JointVector& q) const noexcept;
  /// g(q)^T integrated: the potential energy in J, zero with all masses at the base origin's
  /// height.
  [[nodiscard]] double potential_energy(const JointVector& q) const noexcept;
  /// The elbow is the origin of joint 4. Its columns 4 to 7 are zero.
  [[nodiscard]] PointKinematics elbow(const JointVector& q) const noexcept;

  [[nodiscard]] const JointLimits& limits() const noexcept { return limits_; }
  [[nodiscard]] const Eigen::Isometry3d& T_world_base() const noexcept { return T_world_base_; }
  [[nodiscard]] const Eigen::Isometry3d& T_link7_tcp() const noexcept { return T_link7_tcp_; }
  [[nodiscard]] const Eigen::Isometry3d& T_link7_flange() const noexcept { return T_link7_flange_; }

  /// The same arm with `payload`, given in the tool-centre frame, fixed to what it already carries.
  /// @throws InputError for a negative mass.
  [[nodiscard]] ArmModel with_payload(const BodyInertia& payload) const;

 private:
  /// A link with its joint: R_parent_link(q) = R_zero + sin(q) R_sin + (1 - cos(q)) R_cos.
  struct Link {
    Eigen::Matrix3d R_zero;
    Eigen::Matrix3d R_sin;
    Eigen::Matrix3d R_cos;
    Eigen::Vector3d p_parent;  ///< joint origin in the parent link's frame
    Eigen::Vector3d axis;      ///< unit, link frame
    BodyInertia body;          ///< link 7 includes the tool
  };
  /// Orientation and joint origins of the links, world axes, relative to the base origin.
  struct Chain {
    std::array<Eigen::Matrix3d, kArmJoints> R;
    std::array<Eigen::Vector3d, kArmJoints> p;
    std::array<Eigen::Vector3d, kArmJoints> z;  ///< joint axes
  };

  [[nodiscard]] Chain chain(const JointVector& q) const noexcept;

  std::array<Link, kArmJoints> links_;
  JointLimits limits_;
  Eigen::Isometry3d T_world_base_;
  Eigen::Isometry3d T_link7_flange_;
  Eigen::Isometry3d T_link7_tcp_;
};

/// `a` and `b`, given in the same frame, as one rigid body.
[[nodiscard]] BodyInertia combine(const BodyInertia& a, const BodyInertia& b);

/// `body`, given in frame b, expressed in frame a.
[[nodiscard]] BodyInertia transformed(const Eigen::Isometry3d& T_a_b, const BodyInertia& body);

}  // namespace binpick
