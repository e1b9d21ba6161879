#include "control/payload_estimator.h"

#include <gtest/gtest.h>

#include "control/controlled_arm.h"
#include "control/manipulator.h"
#include "control/plant_robot.h"
#include "control/sensor_calibration.h"
#include "models/random.h"

namespace binpick {
namespace {

constexpr double kGravity = 9.81;

Vector6 weight_of(double mass, const Eigen::Vector3d& com, const Eigen::Isometry3d& T_world_tcp) {
  const Eigen::Vector3d force(0.0, 0.0, -mass * kGravity);
  Vector6 wrench;
  wrench << force, (T_world_tcp.linear() * com).cross(force);
  return wrench;
}

TEST(PayloadEstimator, ThreeOrientationsTellMassAndCentreOfMass) {
  Random random(derive_seed(5, "payload"));
  const Eigen::Vector3d com(0.01, -0.02, 0.05);
  PayloadEstimator estimator;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Isometry3d T(random.rotation());
    estimator.add(weight_of(1.1, com, T), T);
  }
  EXPECT_NEAR(estimator.estimate().mass, 1.1, 1e-9);
  EXPECT_LT((estimator.estimate().com - com).norm(), 1e-3);
}

TEST(PayloadEstimator, OneOrientationTellsAllButTheOffsetAlongGravity) {
  Eigen::Isometry3d down = Eigen::Isometry3d::Identity();
  down.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  PayloadEstimator estimator;
  estimator.add(weight_of(0.4, {0.015, -0.01, 0.07}, down), down);
  EXPECT_LT((estimator.estimate().com - Eigen::Vector3d(0.015, -0.01, 0.0)).norm(), 1e-4);
}

TEST(PayloadEstimator, AnUpwardPullIsNoLoad) {
  PayloadEstimator estimator;
  EXPECT_EQ(estimator.estimate().mass, 0.0);
  estimator.add(Vector6::Unit(2), Eigen::Isometry3d::Identity());
  EXPECT_EQ(estimator.estimate().mass, 0.0);
  EXPECT_EQ(estimator.estimate().com, Eigen::Vector3d::Zero());
}

TEST(PayloadEstimator, TheWeighedLoadIsCarriedWithoutAResidual) {
  // A bottle of 1.1 kg held off its centre, noisy sensors with offsets, joints elastic.
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  BodyInertia bottle;
  bottle.mass = 1.1;
  bottle.com = Eigen::Vector3d(0.01, 0.015, 0.03);
  bottle.inertia = Eigen::Vector3d(0.008, 0.008, 0.001).asDiagonal();

  PlantRobot robot(ArmPlant(model, pose, load_lwr_drives().with_friction(0.0), 3));
  const ElasticJoints joints = ElasticJoints::of(load_lwr_drives());
  TorqueFeedback feedback(joints);
  robot.set_torque_loop(feedback.loop());
  ArmControllerOptions options;
  options.joints = joints;
  Manipulator manipulator(robot, model, options);
  manipulator.hold(0.5);
  ASSERT_TRUE(manipulator.calibrate_sensors());
  EXPECT_LT((manipulator.controller().sensor_offset() - robot.plant().sensor_offset())
                .cwiseAbs()
                .maxCoeff(),
            0.03);

  robot.set_external([&](const ArmDynamics& dynamics, const JointVector&) {
    return JointVector(dynamics.J.transpose() *
                       weight_of(bottle.mass, bottle.com, dynamics.T_world_tcp));
  });
  manipulator.hold(1.0, {.on_collision = false});
  const BodyInertia weighed = manipulator.weigh(0.2);
  EXPECT_NEAR(weighed.mass, bottle.mass, 0.03);
  EXPECT_LT((weighed.com - bottle.com).head<2>().norm(), 0.005);
  manipulator.controller().set_payload(weighed);
  manipulator.hold(0.5);
  EXPECT_LT(manipulator.controller().status().external_wrench.head<3>().norm(), 1.0);
  EXPECT_FALSE(manipulator.controller().status().contact);
}

TEST(SensorCalibration, AMovingArmIsNotCalibrated) {
  SensorCalibration calibration;
  const JointVector ones = JointVector::Ones();
  for (int i = 0; i < 200; ++i) calibration.add(1.2 * ones, ones, 0.02 * ones);
  EXPECT_FALSE(calibration.offset());
}

TEST(SensorCalibration, ItsOffsetIsTheMeanBeyondGravity) {
  SensorCalibration calibration;
  const JointVector ones = JointVector::Ones();
  for (int i = 0; i < 50; ++i) calibration.add(1.2 * ones, ones, JointVector::Zero());
  EXPECT_FALSE(calibration.offset()) << "too few readings";
  for (int i = 0; i < 50; ++i) calibration.add(-0.6 * ones, -ones, JointVector::Zero());
  ASSERT_TRUE(calibration.offset());
  EXPECT_LT((*calibration.offset() - 0.3 * ones).norm(), 1e-12);
}

}  // namespace
}  // namespace binpick
