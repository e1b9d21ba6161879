#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "control/arm_controller.h"
#include "control/arm_plant.h"
#include "control/cartesian_trajectory.h"
#include "control/elastic_joints.h"
#include "control/test_arm.h"
#include "models/random.h"

namespace binpick {

/// Within this time the controller has to brake a joint that something outside has thrown beyond
/// its speed limit: with 1000 Nm/s it takes that long to turn a joint's torque round.
inline constexpr int kBrakingTicks = 100;

/// ArmController on the plant, with torque feedback where the plant's joints are elastic. The
/// limits are asserted in the loop: in every tick torques are finite, within effort and rate
/// limits, and joints within their position and speed limits.
///
/// What strikes the arm can drive a joint beyond its speed limit: M^-1 times its impulse is the
/// speed that it adds, whatever the motors do, and they hardly do anything while it lasts. Springs
/// may give that speed back the other way. So much and no more is allowed above the limit, and for
/// kBrakingTicks; an arm that nothing pushes has no such allowance.
class ControlledArm {
 public:
  ControlledArm(const ArmModel& belief, ArmPlant arm, ArmControllerOptions options = {})
      : plant(std::move(arm)), controller(belief, for_plant(options, plant)) {
    if (plant.drives()) {
      feedback = std::make_unique<TorqueFeedback>(ElasticJoints::of(*plant.drives()));
      loop_ = feedback->loop();
    }
  }
  ControlledArm(const ArmModel& belief, const ArmModel& truth, const JointVector& q,
                const ArmControllerOptions& options = {})
      : ControlledArm(belief, ArmPlant(truth, q), options) {}
  ControlledArm(const ArmModel& model, const JointVector& q) : ControlledArm(model, model, q) {}

  /// What elastic drives make the motors weigh is told to the controller.
  static ArmControllerOptions for_plant(ArmControllerOptions options, const ArmPlant& plant) {
    if (plant.drives()) options.joints = ElasticJoints::of(*plant.drives());
    return options;
  }

  void tick(const ArmPlant::External& external = nothing_outside()) {
    JointState state = plant.state();
    for (double& tau : state.tau) tau += torque_noise * noise_.normal();
    tick_on(state, external);
  }
  /// The controller is shown `state`, whatever the plant's is.
  void tick_on(const JointState& state, const ArmPlant::External& external = nothing_outside()) {
    const JointVector tau = controller.tick(state, kControlPeriod);
    const JointLimits& limits = plant.model().limits();
    ASSERT_TRUE(tau.allFinite());
    ASSERT_LE((tau.cwiseAbs() - limits.effort).maxCoeff(), 1e-9);
    if (last_tau_) {
      largest_step = std::max(largest_step, (tau - *last_tau_).cwiseAbs().maxCoeff());
      ASSERT_LE(largest_step, 1000.0 * kControlPeriod + 1e-9);
    }
    last_tau_ = tau;
    plant.step_drives(tau, loop_, external);
    ASSERT_TRUE(limits.contains(plant.q())) << plant.q().transpose();
    remember_push(external);
    const JointVector speed = plant.qd().cwiseAbs();
    double& record = thrown_.isZero(0.0) ? fastest : fastest_struck;
    record = std::max(record, speed.cwiseQuotient(limits.velocity).maxCoeff());
    ASSERT_LE((speed - limits.velocity - thrown_).maxCoeff(), 0.0) << plant.qd().transpose();
  }
  void run(double seconds, const ArmPlant::External& external = nothing_outside()) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kControlPeriod)); ++i) {
      tick(external);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }

  /// Of the tool from `T_world_target`, target axes: m and the rotation vector.
  [[nodiscard]] Vector6 displacement(const Eigen::Isometry3d& T_world_target) const {
    const Eigen::Isometry3d T =
        T_world_target.inverse() * plant.model().forward_kinematics(plant.q());
    const Eigen::AngleAxisd rotation(T.linear());
    Vector6 result;
    result << T.translation(), rotation.angle() * rotation.axis();
    return result;
  }

  ArmPlant plant;
  ArmController controller;
  std::unique_ptr<TorqueFeedback> feedback;
  double torque_noise = 0.0;    ///< standard deviation, Nm, on top of the plant's own
  double fastest = 0.0;         ///< joint speed of the free arm so far, in units of its limit
  double fastest_struck = 0.0;  ///< the same while something pushes it
  double largest_step = 0.0;    ///< of a joint torque between two ticks, Nm

 private:
  void remember_push(const ArmPlant::External& external) {
    const ArmDynamics dynamics = plant.dynamics();
    const JointVector push = external(dynamics, plant.qd());
    JointVector added = JointVector::Zero();
    if (!push.isZero(0.0)) added = kControlPeriod * dynamics.M.llt().solve(push).cwiseAbs();
    pushes_[next_push_++ % kBrakingTicks] = added;
    thrown_.setZero();
    for (const JointVector& speed : pushes_) thrown_ += speed;
  }

  Random noise_{derive_seed(11, "torque sensor")};
  JointTorqueLoop loop_;
  std::optional<JointVector> last_tau_;
  std::vector<JointVector> pushes_ =
      std::vector<JointVector>(kBrakingTicks, JointVector::Zero());  ///< a ring, rad/s per tick
  std::size_t next_push_ = 0;
  JointVector thrown_ = JointVector::Zero();  ///< what the last pushes added to the speeds, rad/s
};

/// The arm's elastic drives without friction, their sensors ideal.
inline DriveDescription ideal_drives() {
  return load_lwr_drives().with_friction(0.0).with_ideal_sensors();
}

/// The tool of `pose` after moving straight by `offset`; m, m/s.
inline CartesianTrajectory line_from(const ArmModel& model, const JointVector& pose,
                                     const Eigen::Vector3d& offset, double speed) {
  const Eigen::Isometry3d start = model.forward_kinematics(pose);
  Eigen::Isometry3d goal = start;
  goal.translation() += offset;
  CartesianMotionLimits limits;
  limits.linear = {speed, 8.0, 400.0};
  return {start, goal, limits};
}

/// The arm with each link's mass and inertia off by up to `share`.
inline ArmModel wrong_masses(double share, Random& random) {
  RobotDescription robot = load_lwr();
  for (LinkDescription& link : robot.links) {
    const double factor = 1.0 + random.uniform(-share, share);
    link.inertia.mass *= factor;
    link.inertia.inertia *= factor;
  }
  return {robot, load_gripper()};
}

}  // namespace binpick
