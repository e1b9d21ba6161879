#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <functional>
#include <vector>

#include "control/arm_model.h"
#include "control/operational_space.h"

namespace binpick {

/// The rigid arm as a plant for controller tests: M qdd + C qd + g = tau + tau_ext, integrated with
/// Runge-Kutta of fourth order; torques are held over a period, as motors do.
class ArmPlant {
 public:
  /// External joint torques at a state.
  using External = std::function<JointVector(const ArmDynamics&, const JointVector& qd)>;

  ArmPlant(const ArmModel& model, const JointVector& q) : model_(model), q_(q) {
    tau_ = model_.gravity(q);
  }

  /// One period of `dt` in `substeps` steps.
  void step(const JointVector& tau, const External& external, double dt = kControlPeriod,
            int substeps = 1) {
    tau_ = tau;
    const double h = dt / substeps;
    for (int i = 0; i < substeps; ++i) {
      const JointVector a1 = acceleration(q_, qd_, external);
      const JointVector v2 = qd_ + 0.5 * h * a1;
      const JointVector a2 = acceleration(q_ + 0.5 * h * qd_, v2, external);
      const JointVector v3 = qd_ + 0.5 * h * a2;
      const JointVector a3 = acceleration(q_ + 0.5 * h * v2, v3, external);
      const JointVector v4 = qd_ + h * a3;
      const JointVector a4 = acceleration(q_ + h * v3, v4, external);
      const JointVector mean_velocity = (qd_ + 2.0 * v2 + 2.0 * v3 + v4) / 6.0;
      work_ += h * mean_velocity.dot(external_torques(q_ + 0.5 * h * v2, v3, external));
      q_ += h * mean_velocity;
      qd_ += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
  }
  void step(const JointVector& tau, double dt = kControlPeriod) {
    step(
        tau, [](const ArmDynamics&, const JointVector&) { return JointVector::Zero().eval(); }, dt);
  }

  [[nodiscard]] JointState state() const { return {q_, qd_, tau_, q_}; }
  [[nodiscard]] ArmDynamics dynamics() const { return model_.evaluate(q_, qd_); }
  [[nodiscard]] double kinetic_energy() const { return 0.5 * qd_.dot(dynamics().M * qd_); }
  /// Done by the external torques so far, J.
  [[nodiscard]] double external_work() const { return work_; }
  [[nodiscard]] const JointVector& q() const { return q_; }
  [[nodiscard]] const JointVector& qd() const { return qd_; }
  [[nodiscard]] const ArmModel& model() const { return model_; }
  void set_velocity(const JointVector& qd) { qd_ = qd; }

 private:
  [[nodiscard]] JointVector external_torques(const JointVector& q, const JointVector& qd,
                                             const External& external) const {
    return external(model_.evaluate(q, qd), qd);
  }
  [[nodiscard]] JointVector acceleration(const JointVector& q, const JointVector& qd,
                                         const External& external) const {
    const ArmDynamics dynamics = model_.evaluate(q, qd);
    const JointVector force = tau_ + external(dynamics, qd) - dynamics.coriolis - dynamics.gravity;
    return dynamics.M.llt().solve(force);
  }

  ArmModel model_;
  JointVector q_;
  JointVector qd_ = JointVector::Zero();
  JointVector tau_;
  double work_ = 0.0;
};

/// A constant wrench on the tool centre, world axes.
inline ArmPlant::External wrench_at_tool(const Vector6& wrench) {
  return [wrench](const ArmDynamics& dynamics, const JointVector&) {
    return JointVector(dynamics.J.transpose() * wrench);
  };
}

/// Tool pointing down in front of the arm, and two poses in general position.
inline std::vector<JointVector> test_poses() {
  return {(JointVector() << 0.0, -0.5, 0.0, 1.5, 0.0, -1.14, 0.0).finished(),
          (JointVector() << 0.7, -0.7, 0.4, 1.3, -0.5, -0.9, 0.6).finished(),
          (JointVector() << -0.9, -0.3, -0.5, 1.6, 0.8, -0.8, -1.1).finished()};
}

/// The nine stiffness pairs of IJRR 2012, Table 1, in tool axes; the others at 2000 N/m and
/// 200 Nm/rad.
inline std::vector<Vector6> table_one_stiffnesses() {
  std::vector<Vector6> all;
  for (const double k_ty : {200.0, 750.0, 2000.0}) {
    for (const double k_rx : {20.0, 75.0, 200.0}) {
      all.push_back((Vector6() << 2000, k_ty, 2000, k_rx, 200, 200).finished());
    }
  }
  return all;
}

}  // namespace binpick
