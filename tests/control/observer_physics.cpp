// The disturbance observer on the arm with elastic joints: steps of joint torque and of the tool's
// wrench, friction, noise.
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "control/controlled_arm.h"

namespace binpick {
namespace {

constexpr double kGain = 50.0;
const double kStepLevel = 1.0 - std::exp(-1.0);

/// Time at which a rising signal, sampled once per period from 0 on, crosses `level`.
double crossing(const std::vector<double>& samples, double level) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i] < level) continue;
    const double part = (level - samples[i - 1]) / (samples[i] - samples[i - 1]);
    return (static_cast<double>(i - 1) + part) * kControlPeriod;
  }
  return INFINITY;
}

struct Response {
  double time_constant = INFINITY;  ///< to 63 % of the step, s
  double final_value = 0.0;
  double coupling = 0.0;  ///< largest value of any other component
};

/// What `read` sees of a step `external`; component `watched` of it should go to `height`.
template <class Vector>
Response respond(ControlledArm& arm, const ArmPlant::External& external, int watched, double height,
                 const std::function<Vector(const ArmStatus&)>& read) {
  Response response;
  std::vector<double> samples{0.0};
  for (int i = 0; i < 300; ++i) {
    arm.tick(external);
    if (::testing::Test::HasFatalFailure()) return response;
    // The status belongs to the state at the tick's beginning.
    if (i == 0) continue;
    Vector value = read(arm.controller.status());
    samples.push_back(value[watched] / height);
    value[watched] = 0.0;
    response.coupling = std::max(response.coupling, value.cwiseAbs().maxCoeff());
  }
  response.time_constant = crossing(samples, kStepLevel);
  response.final_value = samples.back() * height;
  return response;
}

TEST(ObserverPhysics, JointTorquesArriveWithTheTimeConstantWhateverTheFriction) {
  const ArmModel model = testing::make_arm();
  for (const double friction : {0.0, 1.0, 2.0}) {
    const DriveDescription drives = load_lwr_drives().with_friction(friction).with_ideal_sensors();
    for (const JointVector& pose : test_poses()) {
      for (int joint = 0; joint < kArmJoints; ++joint) {
        ControlledArm arm(model, ArmPlant(model, pose, drives));
        const auto torque = [&](const ArmDynamics&, const JointVector&) {
          return JointVector(4.0 * JointVector::Unit(joint));
        };
        const Response response = respond<JointVector>(
            arm, torque, joint, 4.0, [](const ArmStatus& status) { return status.residual; });
        if (HasFatalFailure()) return;
        EXPECT_NEAR(response.time_constant, 1.0 / kGain, 0.05 / kGain) << "joint " << joint;
        EXPECT_NEAR(response.final_value, 4.0, 0.02 * 4.0) << "joint " << joint;
        EXPECT_LT(response.coupling, 0.02 * 4.0) << "joint " << joint;
      }
    }
  }
}

TEST(ObserverPhysics, ToolForcesArriveWithTheTimeConstant) {
  // 10 N along each axis, and about it the 2.8 Nm that they have at the wrist, 0.28 m away; what
  // appears on the others in units of these.
  const Vector6 steps = (Vector6() << 10, 10, 10, 2.8, 2.8, 2.8).finished();
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (int axis = 0; axis < 6; ++axis) {
      ControlledArm arm(model, ArmPlant(model, pose, ideal_drives()));
      const Response response =
          respond<Vector6>(arm, wrench_at_tool(steps[axis] * Vector6::Unit(axis)), axis, 1.0,
                           [&](const ArmStatus& status) {
                             return Vector6(status.external_wrench.cwiseQuotient(steps));
                           });
      if (HasFatalFailure()) return;
      EXPECT_NEAR(response.time_constant, 1.0 / kGain, 0.05 / kGain) << "axis " << axis;
      EXPECT_NEAR(response.final_value, 1.0, 0.02) << "axis " << axis;
      EXPECT_LT(response.coupling, 0.02) << "axis " << axis;
    }
  }
}

TEST(ObserverPhysics, NoiseLeavesItUnbiased) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[1];
  DriveDescription drives = load_lwr_drives().with_friction(0.0);
  drives.torque_offset = 0.0;
  ControlledArm arm(model, ArmPlant(model, pose, drives, 5));
  arm.run(0.2);
  JointVector mean = JointVector::Zero();
  constexpr int kTicks = 3000;
  for (int i = 0; i < kTicks; ++i) {
    arm.tick();
    if (HasFatalFailure()) return;
    mean += arm.controller.status().residual / kTicks;
  }
  // 3 s of 0.1 Nm noise: the mean's standard deviation is 0.002 Nm.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.008);
}

TEST(ObserverPhysics, CalibrationFindsTheSensorsOffsets) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[2];
  ControlledArm arm(model, ArmPlant(model, pose, load_lwr_drives().with_friction(0.0), 9));
  EXPECT_GT(arm.plant.sensor_offset().cwiseAbs().maxCoeff(), 0.1);
  arm.run(0.5);
  arm.controller.zero_observer();
  arm.run(0.3);
  if (HasFatalFailure()) return;
  // The observer passes 0.016 Nm of the noise of 0.1 Nm.
  EXPECT_LT((arm.controller.sensor_offset() - arm.plant.sensor_offset()).cwiseAbs().maxCoeff(),
            0.08);
  EXPECT_LT(arm.controller.status().residual.cwiseAbs().maxCoeff(), 0.12);
}

}  // namespace
}  // namespace binpick
