#include "control/arm_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "control/arm_plant.h"
#include "control/cartesian_trajectory.h"
#include "control/joint_trajectory.h"
#include "control/test_arm.h"
#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

/// The controller on the plant. Every tick is checked: torques finite, within effort and rate
/// limits, joints within their position limits.
class ControlledArm {
 public:
  ControlledArm(const ArmModel& controller_model, const ArmModel& plant_model, const JointVector& q,
                const ArmControllerOptions& options = {})
      : controller(controller_model, options), plant(plant_model, q) {}
  ControlledArm(const ArmModel& model, const JointVector& q) : ControlledArm(model, model, q) {}

  void tick(const ArmPlant::External& external = wrench_at_tool(Vector6::Zero())) {
    JointState state = plant.state();
    for (double& tau : state.tau) tau += torque_noise * noise_.normal();
    const JointVector tau = controller.tick(state, kControlPeriod);
    const JointLimits& limits = plant.model().limits();
    ASSERT_TRUE(tau.allFinite());
    ASSERT_LE((tau.cwiseAbs() - limits.effort).maxCoeff(), 1e-9);
    if (last_tau_) {
      largest_step = std::max(largest_step, (tau - *last_tau_).cwiseAbs().maxCoeff());
      ASSERT_LE(largest_step, 1000.0 * kControlPeriod + 1e-9);
    }
    last_tau_ = tau;
    plant.step(tau, external);
    ASSERT_TRUE(limits.contains(plant.q())) << plant.q().transpose();
    fastest = std::max(fastest, plant.qd().cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff());
  }
  void run(double seconds, const ArmPlant::External& external = wrench_at_tool(Vector6::Zero())) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kControlPeriod)); ++i) {
      tick(external);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }

  ArmController controller;
  ArmPlant plant;
  double torque_noise = 0.0;  ///< standard deviation, Nm
  double fastest = 0.0;       ///< joint speed so far, in units of its limit
  double largest_step = 0.0;  ///< of a joint torque between two ticks, Nm

 private:
  Random noise_{derive_seed(11, "torque sensor")};
  std::optional<JointVector> last_tau_;
};

/// A frictionless elastic floor under the tool centre; k in N/m.
ArmPlant::External floor_at(double height, double k) {
  return [=](const ArmDynamics& dynamics, const JointVector&) {
    const double depth = height - dynamics.T_world_tcp.translation().z();
    return JointVector(dynamics.J.transpose() * (std::max(depth, 0.0) * k * Vector6::Unit(2)));
  };
}

/// The tool of `pose` after moving straight by `offset`.
CartesianTrajectory line_from(const ArmModel& model, const JointVector& pose,
                              const Eigen::Vector3d& offset, double speed) {
  const Eigen::Isometry3d start = model.forward_kinematics(pose);
  Eigen::Isometry3d goal = start;
  goal.translation() += offset;
  CartesianMotionLimits limits;
  limits.linear = {speed, 8.0, 400.0};
  return {start, goal, limits};
}

/// Each link's mass and inertia off by up to `share`.
ArmModel wrong_masses(double share, Random& random) {
  RobotDescription robot = load_lwr();
  for (LinkDescription& link : robot.links) {
    const double factor = 1.0 + random.uniform(-share, share);
    link.inertia.mass *= factor;
    link.inertia.inertia *= factor;
  }
  return {robot, load_gripper()};
}

TEST(ArmController, HoldsTheFirstPoseUntilTold) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    ControlledArm arm(model, pose);
    arm.run(0.5);
    EXPECT_LT((arm.plant.q() - pose).norm(), 1e-6);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kJoint);
    EXPECT_FALSE(arm.controller.status().contact);
  }
}

TEST(ArmController, SwitchesLawsWithoutABump) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ControlledArm arm(model, pose);
  const Eigen::Vector3d start = model.forward_kinematics(pose).translation();
  arm.run(0.2);
  for (int i = 0; i < 4; ++i) {
    arm.controller.set_cartesian_target({.T_world_tcp = arm.controller.status().T_world_tcp});
    arm.run(0.2);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kCartesian);
    arm.controller.set_joint_target({.q = arm.controller.status().q});
    arm.run(0.2);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kJoint);
  }
  EXPECT_LT((model.forward_kinematics(arm.plant.q()).translation() - start).norm(), 1e-4);
  EXPECT_LT(arm.largest_step, 0.1);
}

TEST(ArmController, RaisesNoFalseAlarmInFastFreeMotions) {
  // 200 motions with torque noise, each with its own 3 % error of every link's mass. Joint motions
  // across the whole workspace at 90 % of the speed limits, singular poses on the way included,
  // and lines at 0.8 m/s alternate.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "free motions"));
  const std::vector<JointVector> poses = test_poses();
  int alarms = 0;
  for (int motion = 0; motion < 200; ++motion) {
    const bool joint_motion = motion % 2 == 0;
    JointVector from = poses[random.index(poses.size())] + testing::random_vector(random, 0.2);
    if (joint_motion) from = testing::random_posture(random, model.limits(), 0.9);
    const JointVector to = testing::random_posture(random, model.limits(), 0.9);
    const JointTrajectory joints({from, to}, model.limits(), {.speed = 0.9});
    const CartesianTrajectory line = line_from(model, from, 0.2 * random.unit_vector(), 0.8);
    ControlledArm arm(model, wrong_masses(0.03, random), from);
    arm.torque_noise = 0.1;
    const double duration = (joint_motion ? joints.duration() : line.duration()) + 0.1;
    for (double t = kControlPeriod; t < duration; t += kControlPeriod) {
      if (joint_motion) {
        const JointTarget sample = joints.sample(t);
        arm.controller.set_joint_target({sample.q, sample.qd, sample.qdd});
      } else {
        const CartesianTarget sample = line.sample(t);
        arm.controller.set_cartesian_target(
            {sample.T_world_tcp, sample.twist, sample.acceleration});
      }
      arm.tick();
      if (HasFatalFailure()) return;
      if (arm.controller.status().collision) {
        ++alarms;
        break;
      }
    }
  }
  EXPECT_EQ(alarms, 0);
}

/// The tool going down onto a floor 0.1 m below, 6 cm past it.
struct FloorImpact {
  double latency = INFINITY;  ///< from the first touch to hf1, s
  double final_force = 0.0;   ///< 0.6 s after the motion's end, N
};
FloorImpact run_into_floor(double speed, double floor_stiffness, bool react) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  const CartesianTrajectory line = line_from(model, pose, {0, 0, -0.16}, speed);
  const double floor_height = model.forward_kinematics(pose).translation().z() - 0.1;
  const ArmPlant::External floor = floor_at(floor_height, floor_stiffness);
  ControlledArm arm(model, pose);
  arm.controller.set_thresholds(
      ContactThresholds::for_phase(ContactPhase::kApproach, model.limits()));
  FloorImpact impact;
  double touched = INFINITY;
  bool stopped = false;
  for (double t = 0.0; t < line.duration() + 0.6; t += kControlPeriod) {
    const CartesianTarget sample = line.sample(t);
    if (!stopped) {
      arm.controller.set_cartesian_target({sample.T_world_tcp, sample.twist, sample.acceleration});
    }
    arm.tick(floor);
    if (::testing::Test::HasFatalFailure()) return impact;
    const double depth = floor_height - model.forward_kinematics(arm.plant.q()).translation().z();
    if (depth > 0.0) touched = std::min(touched, t);
    if (arm.controller.status().collision) {
      impact.latency = std::min(impact.latency, t - touched);
      if (react && !stopped) arm.controller.stop();
      stopped = react;
    }
    impact.final_force = std::max(depth, 0.0) * floor_stiffness;
  }
  return impact;
}

TEST(ArmController, DetectsCollisionsInTime) {
  constexpr double kThreshold = 15.0;
  constexpr double kGain = 50.0;
  for (const double stiffness : {5e3, 3e4}) {
    for (const double speed : {0.1, 0.8}) {
      const FloorImpact impact = run_into_floor(speed, stiffness, true);
      EXPECT_LE(impact.latency, kThreshold / (stiffness * speed) + 2.0 / kGain + 0.002)
          << "speed " << speed << ", stiffness " << stiffness;
    }
    EXPECT_LT(run_into_floor(0.8, stiffness, true).latency,
              run_into_floor(0.1, stiffness, true).latency);
  }
  EXPECT_LT(run_into_floor(0.1, 3e4, true).latency, run_into_floor(0.1, 5e3, true).latency);
}

TEST(ArmController, StopTakesTheSustainedForceAway) {
  for (const double speed : {0.1, 0.8}) {
    const double without = run_into_floor(speed, 5e3, false).final_force;
    const double with = run_into_floor(speed, 5e3, true).final_force;
    EXPECT_GT(without, 50.0);  // the clipped spring's 60 N
    EXPECT_LT(with, 20.0);
  }
}

TEST(ArmController, StopCancelsTheSpringAndEndsTheMotion) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ControlledArm arm(model, pose);
  CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
  far.T_world_tcp.translation().x() += 0.3;
  arm.controller.set_cartesian_target(far);
  arm.run(0.15);
  EXPECT_GT(arm.controller.status().spring_wrench.head<3>().norm(), 20.0);
  arm.controller.stop();
  arm.tick();
  EXPECT_LT(arm.controller.status().spring_wrench.norm(), 1e-6);
  const Eigen::Vector3d stopped_at = arm.controller.status().T_world_tcp.translation();
  arm.run(2.0);
  EXPECT_LT(arm.plant.qd().norm(), 1e-3);
  EXPECT_LT((arm.controller.status().T_world_tcp.translation() - stopped_at).norm(), 2e-3);
}

TEST(ArmController, PayloadIsCarriedOnceItIsKnown) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  BodyInertia bottle;
  bottle.mass = 1.1;
  bottle.com = Eigen::Vector3d(0, 0, 0.05);
  bottle.inertia = Eigen::Vector3d(0.008, 0.008, 0.001).asDiagonal();
  ControlledArm arm(model, model.with_payload(bottle), pose);
  arm.controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(pose)});
  arm.run(1.0);
  EXPECT_NEAR(arm.controller.status().external_wrench.z(), -1.1 * 9.81, 0.3);
  EXPECT_TRUE(arm.controller.status().contact);

  arm.controller.set_payload(bottle);
  arm.controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(pose)});
  arm.run(1.0);
  EXPECT_LT(arm.controller.status().external_wrench.norm(), 0.05);
  EXPECT_FALSE(arm.controller.status().contact);
  const Eigen::Vector3d sag = arm.controller.status().T_world_tcp.translation() -
                              model.forward_kinematics(pose).translation();
  EXPECT_LT(sag.norm(), 1e-4);
}

TEST(ArmController, ZeroingTakesSensorOffsetsAway) {
  const ArmModel model = testing::make_arm();
  ArmController controller(model);
  const JointVector pose = test_poses()[1];
  JointState state{.q = pose, .tau = model.gravity(pose), .theta = pose};
  state.tau += JointVector::Constant(0.3);
  for (int i = 0; i < 500; ++i) (void)controller.tick(state, kControlPeriod);
  EXPECT_NEAR(controller.status().residual[3], -0.3, 1e-3);
  controller.zero_observer();
  (void)controller.tick(state, kControlPeriod);
  EXPECT_LT(controller.status().residual.norm(), 1e-3);
}

TEST(ArmController, StaysWithinTheLimitsForAFarSetPoint) {
  // The checks of every tick are the test. Joint speed is bounded, but not by its limit: the light
  // wrist gains speed faster than torques may change.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "far"));
  for (const JointVector& pose : test_poses()) {
    for (int trial = 0; trial < 3; ++trial) {
      ControlledArm arm(model, pose);
      arm.tick();
      CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
      far.T_world_tcp.translation() += 1.0 * random.unit_vector();
      far.T_world_tcp.rotate(Eigen::AngleAxisd(M_PI, random.unit_vector()));
      arm.controller.set_cartesian_target(far);
      arm.run(3.0);
      EXPECT_NE(arm.controller.status().mode, ControlMode::kSafeStop);
      EXPECT_LT(arm.fastest, 1.6);
    }
  }
}

TEST(ArmController, ASetPointThatJumpsIsApproached) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ControlledArm arm(model, pose);
  CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
  far.T_world_tcp.translation().x() -= 0.1;
  far.T_world_tcp.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  arm.controller.set_cartesian_target(far);
  arm.tick();
  arm.tick();
  EXPECT_LT(arm.controller.status().spring_wrench.head<3>().norm(), 2000.0 * 0.0024 + 1e-9);
  EXPECT_LT(arm.controller.status().spring_wrench.tail<3>().norm(), 200.0 * 0.006 + 1e-9);
  arm.run(2.0);
  const Eigen::Isometry3d error = far.T_world_tcp.inverse() * arm.controller.status().T_world_tcp;
  EXPECT_LT(error.translation().norm(), 1e-3);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 1e-2);
}

TEST(ArmController, ToleratesAMillisecondOfLatency) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ArmController controller(model);
  ArmPlant plant(model, pose);
  CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
  target.T_world_tcp.translation().y() += 0.02;
  controller.set_cartesian_target(target);
  JointVector late = model.gravity(pose);
  for (int i = 0; i < 4000; ++i) {
    const JointVector tau = controller.tick(plant.state(), kControlPeriod);
    plant.step(late);
    late = tau;
  }
  EXPECT_LT(plant.qd().norm(), 1e-3);
  EXPECT_LT(
      (model.forward_kinematics(plant.q()).translation() - target.T_world_tcp.translation()).norm(),
      1e-4);
}

TEST(ArmController, ABadSensorLeadsToASafeStopThatIsSaid) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[1];
  for (const double bad : {NAN, INFINITY}) {
    ControlledArm arm(model, pose);
    arm.plant.set_velocity(JointVector::Constant(0.3));
    arm.run(0.1);
    JointState broken = arm.plant.state();
    broken.q[3] = bad;
    const JointVector tau = arm.controller.tick(broken, kControlPeriod);
    EXPECT_TRUE(tau.allFinite());
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kSafeStop);
    EXPECT_EQ(arm.controller.status().fault, ControlFault::kBadState);

    // With the sensor back it brakes, but stays stopped until reset.
    arm.controller.set_joint_target({.q = pose + JointVector::Ones()});
    for (int i = 0; i < 1500; ++i) {
      arm.plant.step(arm.controller.tick(arm.plant.state(), kControlPeriod));
    }
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kSafeStop);
    EXPECT_LT(arm.plant.qd().norm(), 1e-3);

    arm.controller.reset();
    const JointVector resting = arm.plant.q();
    for (int i = 0; i < 200; ++i) {
      arm.plant.step(arm.controller.tick(arm.plant.state(), kControlPeriod));
    }
    EXPECT_EQ(arm.controller.status().fault, ControlFault::kNone);
    EXPECT_EQ(arm.controller.status().mode, ControlMode::kJoint);
    EXPECT_LT((arm.plant.q() - resting).norm(), 1e-3);
  }
}

TEST(ArmController, ABadTargetOrPeriodLeadsToASafeStopThatIsSaid) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  const JointState state{.q = pose, .tau = model.gravity(pose), .theta = pose};
  {
    ArmController controller(model);
    controller.set_joint_target({.q = JointVector::Constant(NAN)});
    EXPECT_TRUE(controller.tick(state, kControlPeriod).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kBadTarget);
  }
  {
    ArmController controller(model);
    CartesianTarget target;
    target.T_world_tcp.translation().x() = INFINITY;
    controller.set_cartesian_target(target);
    EXPECT_TRUE(controller.tick(state, kControlPeriod).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kBadTarget);
    // Nothing of it is left after a reset.
    controller.reset();
    controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(pose)});
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(controller.tick(state, kControlPeriod).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kNone);
    EXPECT_EQ(controller.status().mode, ControlMode::kCartesian);
  }
  for (const double dt : {0.0, -0.001, 1.0, double{NAN}}) {
    ArmController controller(model);
    EXPECT_TRUE(controller.tick(state, dt).allFinite());
    EXPECT_EQ(controller.status().fault, ControlFault::kBadPeriod);
  }
}

TEST(ArmController, RefusesOptionsWithoutMeaning) {
  ArmControllerOptions options;
  options.limiter.rate = -1.0;
  EXPECT_THROW(ArmController(testing::make_arm(), options), InputError);
}

}  // namespace
}  // namespace binpick
