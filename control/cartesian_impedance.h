#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "control/arm_model.h"
#include "control/damping_design.h"
#include "control/motion_target.h"
#include "control/operational_space.h"

namespace binpick {

struct CartesianImpedanceOptions {
  /// Translational (N/m) and rotational (Nm/rad) stiffness along and about the tool's x, y, z.
  Vector6 stiffness = (Vector6() << 2000, 2000, 2000, 200, 200, 200).finished();
  double damping_ratio = 0.7;  ///< of every mode; 0.7 to 1
  /// The point about which translation and rotation do not couple, in the tool-centre frame, m.
  /// Zero: at the tool centre. Moved by L, a lateral force at the tool centre meets
  /// 1/K_t + L^2/K_r.
  Eigen::Vector3d p_tcp_compliance_centre = Eigen::Vector3d::Zero();
  /// The virtual spring never pulls harder, however far the target is.
  double max_spring_force = 60.0;   ///< N
  double max_spring_torque = 15.0;  ///< Nm
  /// Time for a stiffness to change by its own size. Increases also wait until enough energy has
  /// been dissipated to pay for them.
  double stiffness_ramp = 0.2;  ///< s

  // Null space: the elbow's swivel.
  double posture_stiffness = 10.0;  ///< Nm/rad towards the posture
  /// What posture and limit repulsion may spend before null-space damping has paid it back, J.
  /// Their projection into the null space has no potential; this bounds the energy that it can
  /// make.
  double posture_energy = 1.0;
  double null_space_damping = 6.0;  ///< 1/s: torque per momentum
  double limit_margin = 0.175;      ///< rad before a joint limit where repulsion sets in
  double limit_stiffness = 200.0;   ///< Nm/rad, in the null space
  /// The last stretch before a limit, where the repulsion overrules the task.
  double hard_limit_margin = 0.035;    ///< rad
  double hard_limit_stiffness = 2000;  ///< Nm/rad

  InertiaCap inertia_cap;
  /// Of elastic joints, rad/(Nm), for the damping; zero for rigid ones.
  JointVector joint_compliance = JointVector::Zero();

  /// @throws InputError listing every value that makes no sense.
  void validate() const;
};

/// Cartesian impedance control of the tool centre through joint torques (Albu-Schaeffer et al.
/// 2007; Ott 2008):
///   tau = J^T [F_spring + D (v_d - v) + Lambda (a_d - alpha J_dot qd)] + alpha C qd + tau_null
/// without gravity, which the caller adds. The spring is the gradient of a potential,
///   V = 1/2 e^T K e + 2 eps^T K_o eps,
/// e: offset of the compliance centre, eps: vector part of the unit quaternion of the orientation
/// error, both in the axes of the *target's* tool frame. (Measured axes differ in second order and
/// would leave a spring without a potential.) A clipped spring is the Moreau envelope of V: as if
/// a clutch that slips at the maximal force sat in series, conservative as well.
///
/// alpha in [0, 1] is the share of the present velocity that the target asks for: Coriolis terms
/// are compensated along the planned motion, and left alone, as passivity wants it, when somebody
/// pushes the arm at rest.
///
/// The null-space term is N^T [s (tau_posture + tau_limits) - c M qd] with the dynamically
/// consistent projector N^T = 1 - J^T Jbar^T. Projected, the posture's spring is no gradient any
/// more: moved in circles it could make energy. It therefore pays from a store that starts at
/// `posture_energy` and that the same term's damping refills; s falls from 1 to 0 while the last
/// tenth is spent. Kinetic energy, spring energy and this store together never grow by more than
/// the work put in.
///
/// All feedback enters through `dynamics` and `qd`. With elastic joints these are taken at the
/// static equivalent of the motor position and at the motor velocity, M with the shaped motor
/// inertia; the law stays the same. Its damping, though, would show at the links as less than was
/// asked for, since a motor leads its link by the deflection of the joint between them. With light
/// motors behind the joints' compliance C (at the tool) and the virtual spring K, a mode of the
/// ratio rho = k c shows zeta (1 - 2 (1 - zeta^2) rho) to first order in rho. Hence
///   D' = (1 + (1 - zeta^2) K C) D (1 + (1 - zeta^2) C K),
/// positive definite as D is.
class CartesianImpedance {
 public:
  CartesianImpedance(const JointLimits& limits, const CartesianImpedanceOptions& options);

  /// Forgets all motion: the stiffness in force becomes the requested one, the energy store is
  /// empty, the posture is `q`. Called when the law takes over.
  void start(const JointVector& q) noexcept;

  /// Joint torques without gravity, Nm. Allocates nothing.
  /// @param space built from the same state as `dynamics`.
  [[nodiscard]] JointVector torques(const ArmDynamics& dynamics, const OperationalSpace& space,
                                    const JointVector& q, const JointVector& qd,
                                    const CartesianTarget& target, double dt) noexcept;

  /// The part of the law that depends on positions alone, Nm: spring, posture and limits. What
  /// elastic joints are bent by, besides gravity.
  [[nodiscard]] JointVector static_torques(const ArmDynamics& dynamics,
                                           const OperationalSpace& space, const JointVector& q,
                                           const Eigen::Isometry3d& T_world_target) const noexcept;

  /// Asks for a stiffness, N/m and Nm/rad in tool axes, >= 0; it comes into force along the ramp.
  void set_stiffness(const Vector6& stiffness) noexcept { requested_stiffness_ = stiffness; }
  /// Where the null space pulls the arm; rad.
  void set_posture(const JointVector& q) noexcept { posture_ = q; }

  /// In force now, tool axes.
  [[nodiscard]] const Vector6& stiffness() const noexcept { return stiffness_; }
  /// Of the virtual spring on the tool centre at the last call; world axes, N and Nm.
  [[nodiscard]] const Vector6& spring_wrench() const noexcept { return spring_wrench_; }
  /// Stored in the virtual spring at the last call, J.
  [[nodiscard]] double spring_energy() const noexcept { return spring_energy_; }
  /// Dissipated so far and not yet spent on raising the stiffness, J.
  [[nodiscard]] double energy_store() const noexcept { return energy_store_; }
  /// What is left for posture and limit repulsion to spend, J.
  [[nodiscard]] double posture_store() const noexcept { return posture_store_; }
  [[nodiscard]] const CartesianImpedanceOptions& options() const noexcept { return options_; }

 private:
  /// The virtual spring; axes of the target's tool frame, about the compliance centre.
  struct Spring {
    Vector6 wrench;   ///< on the tool
    Vector6 stretch;  ///< m and 2 eps: the springs' own share, without the clutch's slip
    double energy;    ///< J
  };

  /// In the target's tool axes, about the compliance centre.
  [[nodiscard]] Matrix6 damping_matrix(const ArmDynamics& dynamics, const OperationalSpace& space,
                                       const Matrix6& X) noexcept;
  [[nodiscard]] Spring spring(const Eigen::Isometry3d& T_world_tcp,
                              const Eigen::Isometry3d& T_world_target) const noexcept;
  void ramp_stiffness(const Vector6& stretch, double dissipated_power, double dt) noexcept;
  /// Towards the posture and away from limits; not yet projected.
  [[nodiscard]] JointVector posture_torques(const JointVector& q) const noexcept;
  [[nodiscard]] JointVector hard_limit_torques(const JointVector& q) const noexcept;

  CartesianImpedanceOptions options_;
  JointLimits limits_;
  DampingDesign<6> damping_design_;
  Vector6 requested_stiffness_;
  Vector6 stiffness_;
  JointVector posture_ = JointVector::Zero();
  Vector6 spring_wrench_ = Vector6::Zero();
  double spring_energy_ = 0.0;
  double energy_store_ = 0.0;
  double posture_store_ = 0.0;
};

}  // namespace binpick
