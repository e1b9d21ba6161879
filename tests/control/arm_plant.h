#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "control/arm_model.h"
#include "control/operational_space.h"
#include "models/drive_description.h"
#include "models/random.h"

namespace binpick {

/// The arm as a plant for controller tests. Rigid joints:
///   M(q) qdd + C qd + g = tau + tau_ext.
/// Elastic joints (Spong's reduced model, Albu-Schaeffer et al. 2007, eqs. 1-3), given their
/// drives:
///   M(q) qdd + C qd + g = tau_j + tau_ext,   tau_j = K (theta - q) + D (theta_d - qd),
///   B theta_dd = tau_m - tau_j - f_v theta_d - f_c sgn(theta_d);
///   at rest a motor sticks while |tau_m - tau_j| <= f_c;
///   sensor:  T tau_s_d = K (theta - q) - tau_s,   reading = tau_s + offset + noise.
/// Integrated with Runge-Kutta of fourth order; torques are held over a step, as motors do.
/// Coulomb friction keeps its direction within a substep; a motor that would turn back stops.
class ArmPlant {
 public:
  /// External joint torques at a state of the links.
  using External = std::function<JointVector(const ArmDynamics&, const JointVector& qd)>;

  /// At rest, held by its joints against gravity.
  ArmPlant(const ArmModel& model, const JointVector& q);
  /// With elastic joints. `noise` seeds the sensors' noise and offsets.
  ArmPlant(const ArmModel& model, const JointVector& q, const DriveDescription& drives,
           Seed noise = 0);

  /// `dt` seconds in `substeps` steps under `tau`: joint torques of rigid joints, motor torques of
  /// elastic ones. Elastic joints need substeps of 1/6 ms.
  void step(const JointVector& tau, const External& external, double dt = kControlPeriod,
            int substeps = 1);
  void step(const JointVector& tau, double dt = kControlPeriod);
  /// One control period under the wanted joint torques `tau`, as a robot's drives would do it:
  /// elastic joints call `loop` at its rate, rigid ones put `tau` on the links.
  void step_drives(const JointVector& tau, const JointTorqueLoop& loop, const External& external);

  [[nodiscard]] JointState state() const;
  [[nodiscard]] ArmDynamics dynamics() const { return model_.evaluate(now_.q, now_.qd); }
  /// Of the links, J.
  [[nodiscard]] double kinetic_energy() const { return 0.5 * qd().dot(dynamics().M * qd()); }
  /// Done by the external torques so far, J.
  [[nodiscard]] double external_work() const { return work_; }
  [[nodiscard]] const JointVector& q() const { return now_.q; }
  [[nodiscard]] const JointVector& qd() const { return now_.qd; }
  [[nodiscard]] const JointVector& theta() const { return drives_ ? now_.theta : now_.q; }
  [[nodiscard]] const JointVector& theta_d() const { return drives_ ? now_.theta_d : now_.qd; }
  [[nodiscard]] const ArmModel& model() const { return model_; }
  [[nodiscard]] const std::optional<DriveDescription>& drives() const { return drives_; }
  /// Of the torque sensors, Nm.
  [[nodiscard]] const JointVector& sensor_offset() const { return sensor_offset_; }
  /// Of links and motors alike.
  void set_velocity(const JointVector& qd) { now_.qd = now_.theta_d = qd; }

 private:
  /// A state, or its rate of change.
  struct Motion {
    JointVector q;
    JointVector qd;
    JointVector theta;
    JointVector theta_d;
    double work;

    [[nodiscard]] Motion after(double h, const Motion& rate) const;
  };
  /// Coulomb friction over one substep: direction of sliding, 0 for a motor that sticks.
  [[nodiscard]] JointVector sliding(const JointVector& motor_torque) const;

  void substep(const External& external, double h);
  [[nodiscard]] Motion rate(const Motion& at, const JointVector& slide,
                            const External& external) const;
  [[nodiscard]] JointVector transmitted(const Motion& at) const;
  void read_sensors(double h);

  ArmModel model_;
  std::optional<DriveDescription> drives_;
  Motion now_;
  JointVector tau_;
  JointVector sensed_;  ///< filtered by the sensors' bandwidth, without offset and noise
  JointVector sensor_offset_ = JointVector::Zero();
  JointVector sensor_noise_ = JointVector::Zero();
  Random noise_{0};
  double work_ = 0.0;
};

/// A constant wrench on the tool centre, world axes.
[[nodiscard]] ArmPlant::External wrench_at_tool(const Vector6& wrench);
/// No external torques.
[[nodiscard]] ArmPlant::External nothing_outside();
/// A spring and damper that resists the tool centre beyond the plane n.p = offset, `normal`
/// pointing out of the obstacle; N/m, N s/m. It pushes only.
[[nodiscard]] ArmPlant::External wall(const Eigen::Vector3d& normal, double offset,
                                      double stiffness, double damping = 0.0);

/// Tool pointing down in front of the arm, and two poses in general position.
[[nodiscard]] std::vector<JointVector> test_poses();

/// The nine stiffness pairs of IJRR 2012, Table 1, in tool axes; the others at 2000 N/m and
/// 200 Nm/rad.
[[nodiscard]] std::vector<Vector6> table_one_stiffnesses();

}  // namespace binpick
