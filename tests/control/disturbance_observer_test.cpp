#include "control/disturbance_observer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "control/arm_plant.h"
#include "control/joint_impedance.h"
#include "control/joint_trajectory.h"
#include "control/test_arm.h"
#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

/// The arm under joint impedance, watched by an observer.
class WatchedArm {
 public:
  WatchedArm(const ArmModel& model, const JointVector& q, double gain)
      : observer({.gain = gain}), plant(model, q), law_(model.limits(), {}), target({.q = q}) {
    watch();
  }

  void step(const ArmPlant::External& external) {
    const ArmDynamics dynamics = plant.dynamics();
    const JointVector tau =
        law_.torques(dynamics, plant.q(), plant.qd(), target) + dynamics.gravity;
    plant.step(tau, external);
    watch();
  }

  DisturbanceObserver observer;
  ArmPlant plant;

 private:
  void watch() { observer.update(plant.dynamics(), plant.qd(), plant.state().tau, kControlPeriod); }
  JointImpedance law_;

 public:
  JointTarget target;
};

ArmPlant::External joint_torque(int joint, double value) {
  return [=](const ArmDynamics&, const JointVector&) {
    return JointVector(value * JointVector::Unit(joint));
  };
}

/// Time at which `value(t)` of a rising signal, sampled from 0 on, crosses `level`.
double crossing(const std::vector<double>& samples, double level) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i] < level) continue;
    const double part = (level - samples[i - 1]) / (samples[i] - samples[i - 1]);
    return (static_cast<double>(i - 1) + part) * kControlPeriod;
  }
  return INFINITY;
}

TEST(DisturbanceObserver, FollowsAJointTorqueWithItsTimeConstantAlone) {
  const ArmModel model = testing::make_arm();
  for (const double gain : {50.0, 100.0}) {
    for (const JointVector& pose : test_poses()) {
      for (int joint = 0; joint < kArmJoints; ++joint) {
        WatchedArm arm(model, pose, gain);
        std::vector<double> response{0.0};
        double coupling = 0.0;
        for (int i = 0; i < 400; ++i) {
          arm.step(joint_torque(joint, 4.0));
          JointVector residual = arm.observer.residual();
          response.push_back(residual[joint]);
          residual[joint] = 0.0;
          coupling = std::max(coupling, residual.cwiseAbs().maxCoeff());
        }
        EXPECT_NEAR(crossing(response, 4.0 * (1.0 - std::exp(-1.0))), 1.0 / gain, 0.05 / gain);
        EXPECT_NEAR(response.back(), 4.0, 0.01);
        EXPECT_LT(coupling, 0.02 * 4.0);
      }
    }
  }
}

TEST(DisturbanceObserver, EstimatesAToolWrench) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (int axis = 0; axis < 6; ++axis) {
      WatchedArm arm(model, pose, 50.0);
      const Vector6 wrench = (axis < 3 ? 10.0 : 1.0) * Vector6::Unit(axis);
      for (int i = 0; i < 600; ++i) arm.step(wrench_at_tool(wrench));
      const ArmDynamics dynamics = arm.plant.dynamics();
      const OperationalSpace space(dynamics.M, dynamics.J);
      const Vector6 error = arm.observer.external_wrench(space) - wrench;
      EXPECT_LT(error.norm(), 0.02 * wrench.norm());
    }
  }
}

TEST(DisturbanceObserver, SeesNothingDuringAFastFreeMotion) {
  const ArmModel model = testing::make_arm();
  const std::vector<JointVector> poses = test_poses();
  const JointTrajectory trajectory({poses[0], poses[1], poses[2], poses[0]}, model.limits(),
                                   {.speed = 1.0});
  WatchedArm arm(model, poses[0], 50.0);
  double worst = 0.0;
  for (double t = 0.0; t < trajectory.duration(); t += kControlPeriod) {
    const JointTarget sample = trajectory.sample(t);
    arm.target = {sample.q, sample.qd, sample.qdd};
    arm.step(wrench_at_tool(Vector6::Zero()));
    worst = std::max(worst, arm.observer.residual().cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 0.02);
}

TEST(DisturbanceObserver, IsUnbiasedUnderSensorNoise) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[1];
  const ArmDynamics dynamics = model.evaluate(pose, JointVector::Zero());
  DisturbanceObserver observer({.gain = 50.0});
  Random random(derive_seed(3, "noise"));
  JointVector mean = JointVector::Zero();
  constexpr int kTicks = 40000;
  for (int i = 0; i < kTicks; ++i) {
    JointVector noise;
    for (double& value : noise) value = 0.1 * random.normal();
    observer.update(dynamics, JointVector::Zero(), dynamics.gravity + noise, kControlPeriod);
    mean += observer.residual() / kTicks;
  }
  // The mean of 40 s of 0.1 Nm noise has a standard deviation of 0.0005 Nm.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.0025);
}

TEST(DisturbanceObserver, TimeConstantDoesNotDependOnThePeriod) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  const ArmDynamics dynamics = model.evaluate(pose, JointVector::Zero());
  const JointVector tau = dynamics.gravity - JointVector::Ones();
  for (const double dt : {0.0005, 0.001, 0.004}) {
    DisturbanceObserver observer({.gain = 50.0});
    const int steps = static_cast<int>(std::lround(0.02 / dt));
    for (int i = 0; i <= steps; ++i) observer.update(dynamics, JointVector::Zero(), tau, dt);
    EXPECT_NEAR(observer.residual()[0], 1.0 - std::exp(-1.0), 1e-9);
  }
}

TEST(DisturbanceObserver, RefusesAGainWithoutMeaning) {
  EXPECT_THROW(DisturbanceObserver({.gain = 0.0}), InputError);
}

}  // namespace
}  // namespace binpick
