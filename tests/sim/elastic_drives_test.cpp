#include "sim/elastic_drives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;
using testing::step_for;

constexpr double kStep = kControlPeriod / kTorqueLoopsPerControl;

DriveDescription frictionless() {
  return load_lwr_drives().with_friction(0.0).with_ideal_sensors();
}

World elastic_world(const DriveDescription& drives, int substeps = 1) {
  const auto shared = cell("blind_bottle");
  return World(shared, centre_physics(shared->parts.objects), drives, substeps);
}

/// Seven links of inertia `inertia` without gravity, for drives alone.
struct FreeLinks {
  JointVector inertia;
  JointVector q = JointVector::Zero();
  JointVector qd = JointVector::Zero();

  void step(ElasticDrives& drives, double h, int short_steps = 1) {
    const ElasticDrives::Coupling coupling = drives.begin_step(q, qd, h, short_steps);
    qd += h * coupling.torque.cwiseQuotient(inertia + coupling.armature);
    q += h * qd;
    drives.end_step(qd);
  }
};

TEST(ElasticDrives, MotorOnAHeldLinkSwingsAtItsNaturalFrequency) {
  const DriveDescription description = frictionless();
  ElasticDrives drives(description);
  FreeLinks held{JointVector::Constant(1e9)};
  drives.reset(held.q, JointVector::Constant(10.0));
  drives.set_motor_torques(JointVector::Zero());
  // The first upward passage through zero comes after three quarters of a damped period.
  JointVector crossing = JointVector::Zero();
  JointVector second_peak = JointVector::Zero();
  for (int i = 1; i < 3000; ++i) {
    const JointVector before = drives.theta();
    held.step(drives, kStep);
    for (int joint = 0; joint < kArmJoints; ++joint) {
      if (crossing[joint] == 0.0 && before[joint] < 0.0 && drives.theta()[joint] >= 0.0) {
        crossing[joint] = i * kStep;
      }
      if (crossing[joint] > 0.0) {
        second_peak[joint] = std::max(second_peak[joint], drives.theta()[joint]);
      }
    }
  }
  for (int joint = 0; joint < kArmJoints; ++joint) {
    const double K = description.stiffness[joint];
    const double omega = std::sqrt(K / description.motor_inertia[joint]);
    constexpr double kRatio = 0.05;
    const double damped = omega * std::sqrt(1.0 - kRatio * kRatio);
    const double zero = (1.5 * std::numbers::pi + std::asin(kRatio)) / damped;
    EXPECT_NEAR(crossing[joint], zero, 0.01 * zero + kStep) << joint;
    const double decay = std::exp(-2.0 * std::numbers::pi * kRatio / std::sqrt(1.0 - 0.0025));
    EXPECT_NEAR(second_peak[joint], 10.0 / K * decay, 0.02 * 10.0 / K) << joint;
  }
}

TEST(ElasticDrives, TheSpringsTakeNoMomentum) {
  const DriveDescription description = frictionless();
  for (const int short_steps : {1, kTorqueLoopsPerControl}) {
    ElasticDrives drives(description);
    FreeLinks links{JointVector::Constant(0.05)};
    drives.reset(links.q, JointVector::Constant(20.0));
    drives.set_motor_torques(JointVector::Zero());
    for (int i = 0; i < 3000; ++i) {
      links.step(drives, short_steps * kStep, short_steps);
      const JointVector momentum = links.inertia.cwiseProduct(links.qd) +
                                   description.motor_inertia.cwiseProduct(drives.theta_d());
      ASSERT_LT(momentum.cwiseAbs().maxCoeff(), 1e-12) << i;
    }
    EXPECT_LT(links.qd.cwiseAbs().maxCoeff(), 1e-3);  // the dampers have taken the energy
  }
}

TEST(ElasticDrives, LongStepsNeitherDampNorDriveTheSprings) {
  // Without dampers, links whose springs swing at 300 to 1200 rad/s against the motors keep doing
  // so for 10 s, several thousand periods, in steps as long as the world's.
  DriveDescription description = frictionless();
  description.damping.setZero();
  ElasticDrives drives(description);
  FreeLinks links{JointVector::Zero()};
  for (int joint = 0; joint < kArmJoints; ++joint) {
    const double omega = 300.0 + 150.0 * joint;
    links.inertia[joint] = description.stiffness[joint] / (omega * omega);
  }
  drives.reset(links.q, JointVector::Constant(10.0));
  drives.set_motor_torques(JointVector::Zero());
  JointVector first = JointVector::Zero();
  JointVector last = JointVector::Zero();
  for (int i = 0; i < 10000; ++i) {
    links.step(drives, kControlPeriod, kTorqueLoopsPerControl);
    if (i < 100) first = first.cwiseMax(links.qd.cwiseAbs());
    if (i >= 9900) last = last.cwiseMax(links.qd.cwiseAbs());
  }
  EXPECT_LT((last.cwiseQuotient(first).array() - 1.0).abs().maxCoeff(), 0.02) << last.transpose();
}

TEST(ElasticDrives, CoulombFrictionHoldsUpToItsLimitAndSubtractsBeyond) {
  DriveDescription description = load_lwr_drives();
  description.viscous_friction.setZero();
  description.stiffness.setConstant(1e-6);
  description.damping.setZero();
  ElasticDrives drives(description);
  FreeLinks held{JointVector::Constant(1e9)};
  drives.reset(held.q, JointVector::Zero());
  drives.set_motor_torques(0.99 * description.coulomb_friction);
  for (int i = 0; i < 300; ++i) held.step(drives, kStep);
  EXPECT_EQ(drives.theta(), JointVector(JointVector::Zero()));

  drives.set_motor_torques(1.5 * description.coulomb_friction);
  for (int i = 0; i < 300; ++i) held.step(drives, kStep);
  const JointVector expected =
      0.1 * 0.5 * description.coulomb_friction.cwiseQuotient(description.motor_inertia);
  EXPECT_LT((drives.theta_d() - expected).norm(), 1e-6);

  drives.set_motor_torques(JointVector::Zero());
  for (int i = 0; i < 3000; ++i) held.step(drives, kStep);
  EXPECT_EQ(drives.theta_d(), JointVector(JointVector::Zero()));
}

TEST(ElasticDrives, SensorsFollowTheSpringWithTheirBandwidth) {
  DriveDescription description = frictionless();
  description.torque_bandwidth = 50.0;
  ElasticDrives drives(description);
  FreeLinks held{JointVector::Constant(1e9)};
  drives.reset(held.q, JointVector::Zero());
  held.q.setConstant(-0.001);  // the links jump: the springs carry K / 1000 at once
  const double time_constant = 1.0 / (2.0 * std::numbers::pi * 50.0);
  drives.set_motor_torques(0.001 * description.stiffness);
  const int steps = static_cast<int>(std::lround(time_constant / kStep));
  for (int i = 0; i < steps; ++i) held.step(drives, kStep);
  const double share = 1.0 - std::exp(-steps * kStep / time_constant);
  for (int joint = 0; joint < kArmJoints; ++joint) {
    EXPECT_NEAR(drives.sensed_torque()[joint], share * 0.001 * description.stiffness[joint],
                0.02 * 0.001 * description.stiffness[joint]);
  }
}

// Open loop through 0.3 s of motion in all joints.
JointVector swing(World& world, JointVector* tau = nullptr) {
  world.park_object(0);
  world.hold_arm(false);
  const JointVector balance = world.balancing_torques();
  for (int i = 0; i < 300; ++i) {
    JointVector torque = balance;
    for (int joint = 0; joint < kArmJoints; ++joint) {
      torque[joint] += (joint < 4 ? 20.0 : 3.0) * std::sin(0.02 * i * (1.0 + 0.3 * joint));
    }
    world.set_arm_torques(torque);
    world.step();
  }
  if (tau != nullptr) *tau = world.sensors().joints.tau;
  return world.sensors().joints.q;
}

TEST(ElasticArm, AgreesWithStepsSixteenTimesFiner) {
  JointVector tau, tau_fine, tau_finer;
  World coarse = elastic_world(frictionless());
  World fine = elastic_world(frictionless(), 4 * kTorqueLoopsPerControl);
  World finer = elastic_world(frictionless(), 16 * kTorqueLoopsPerControl);
  const JointVector start = coarse.sensors().joints.q;
  const JointVector q = swing(coarse, &tau);
  const JointVector q_fine = swing(fine, &tau_fine);
  const JointVector q_finer = swing(finer, &tau_finer);
  const double travelled = (q_finer - start).cwiseAbs().maxCoeff();
  const double error = (q - q_finer).cwiseAbs().maxCoeff();
  const double error_fine = (q_fine - q_finer).cwiseAbs().maxCoeff();
  RecordProperty("travelled_rad", std::to_string(travelled));
  RecordProperty("error_rad", std::to_string(error));
  EXPECT_GT(travelled, 0.05);
  EXPECT_LT(error, 0.005 * travelled);
  EXPECT_LT((tau - tau_finer).cwiseAbs().maxCoeff(), 0.5);
  EXPECT_LT(error_fine, 0.3 * error);  // the error falls with the step
}

TEST(ElasticArm, HangsInItsSpringsByItsWeight) {
  World world = elastic_world(frictionless());
  world.park_object(0);
  step_for(world, 0.01);
  const JointVector weight = world.balancing_torques();
  const RobotState state = world.sensors();
  const JointVector stretch = state.joints.theta - state.joints.q;
  EXPECT_LT((stretch.cwiseProduct(frictionless().stiffness) - weight).norm(), 1e-6);
  EXPECT_GT(weight.norm(), 10.0);
  world.hold_arm(false);
  world.set_arm_torques(weight);
  const JointVector q = state.joints.q;
  step_for(world, 3.0);
  EXPECT_LT((world.sensors().joints.q - q).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((world.sensors().joints.tau - weight).cwiseAbs().maxCoeff(), 0.01);
}

TEST(ElasticArm, RestoredStateContinuesBitForBit) {
  const DriveDescription drives = load_lwr_drives();
  World world = elastic_world(drives);
  swing(world);
  const WorldState middle = world.save_state();
  step_for(world, 0.2);
  World other = elastic_world(drives);
  other.restore_state(middle);
  step_for(other, 0.2);
  EXPECT_EQ(world.save_state().numbers, other.save_state().numbers);
  EXPECT_EQ(world.sensors().joints.theta, other.sensors().joints.theta);
  EXPECT_THROW(testing::make_world("blind_bottle").restore_state(middle), std::invalid_argument);
}

TEST(ElasticArm, RunsItsTorqueLoopAtThreeKilohertz) {
  World world = elastic_world(frictionless());
  int calls = 0;
  world.set_torque_loop([&](const JointState& state) {
    ++calls;
    return JointVector(state.tau);
  });
  step_for(world, 0.01);
  EXPECT_EQ(calls, 0);  // brakes closed
  world.hold_arm(false);
  step_for(world, 0.01);
  EXPECT_EQ(calls, 30);
}

}  // namespace
}  // namespace binpick
