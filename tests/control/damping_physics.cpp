// Damping ratio from free release, and tracking, with the whole controller in the loop.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "control/controlled_arm.h"

namespace binpick {
namespace {

Matrix6 about(const Eigen::Matrix3d& R) {
  Matrix6 X = Matrix6::Zero();
  X.topLeftCorner<3, 3>() = R;
  X.bottomRightCorner<3, 3>() = R;
  return X;
}

/// The damping ratio of one mode of K v = w^2 Lambda v, measured: the tool is released with the
/// spring stretched along v, and its overshoot tells zeta; 1 without any.
double measured_ratio(const ArmPlant& at_rest, const Vector6& stiffness, double zeta, int mode) {
  const ArmModel& model = at_rest.model();
  ArmPlant plant = at_rest;
  ArmControllerOptions options;
  options.cartesian.stiffness = stiffness;
  options.cartesian.damping_ratio = zeta;
  options.max_target_speed = 1e3;  // released at once, not approached
  options.max_target_turn = 1e4;
  options.limiter.rate = 1e6;
  const ElasticJoints joints = ElasticJoints::of(load_lwr_drives());
  const TorqueFeedback feedback(joints);
  const JointTorqueLoop loop = feedback.loop();
  ArmController controller(model, ControlledArm::for_plant(options, plant));

  ArmDynamics dynamics = plant.dynamics();
  if (plant.drives()) dynamics.M.diagonal() += joints.shaped_inertia();
  const Eigen::Isometry3d T = dynamics.T_world_tcp;
  const Matrix6 R = about(T.linear());
  const Matrix6 K = R * stiffness.asDiagonal() * R.transpose();
  const Matrix6 Lambda = (dynamics.J * dynamics.M.inverse() * dynamics.J.transpose()).inverse();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> modes(K, Lambda);
  Vector6 v = modes.eigenvectors().col(mode);
  v *= 0.005 / std::max(v.head<3>().norm(), v.tail<3>().norm());
  CartesianTarget target{.T_world_tcp = T};
  target.T_world_tcp.translation() += v.head<3>();
  target.T_world_tcp.linear() =
      Eigen::AngleAxisd(v.tail<3>().norm(), v.tail<3>().normalized()) * T.linear();
  controller.set_cartesian_target({.T_world_tcp = T});
  plant.step_drives(controller.tick(plant.state(), kControlPeriod), loop, nothing_outside());
  controller.set_cartesian_target(target);

  const Vector6 to_mode = Lambda * v / v.dot(Lambda * v);
  const double frequency = std::sqrt(modes.eigenvalues()[mode]);
  double overshoot = 0.0;
  for (double t = 0.0; t < 8.0 / frequency; t += kControlPeriod) {
    plant.step_drives(controller.tick(plant.state(), kControlPeriod), loop, nothing_outside());
    const Eigen::Isometry3d now = model.forward_kinematics(plant.q());
    Vector6 off;
    off << now.translation() - target.T_world_tcp.translation(),
        testing::rotation_between(target.T_world_tcp.linear(), now.linear());
    overshoot = std::max(overshoot, to_mode.dot(off));
  }
  if (overshoot <= 0.0) return 1.0;
  const double log_overshoot = -std::log(overshoot);
  return log_overshoot / std::hypot(M_PI, log_overshoot);
}

TEST(DampingPhysics, FreeReleaseShowsTheCommandedRatio) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (const Vector6& stiffness : table_one_stiffnesses()) {
      for (int mode = 0; mode < 6; ++mode) {
        EXPECT_NEAR(measured_ratio({model, pose}, stiffness, 0.7, mode), 0.7, 0.15 * 0.7)
            << "mode " << mode << ", stiffness " << stiffness.transpose();
      }
    }
  }
}

TEST(DampingPhysics, ElasticJointsShowTheCommandedRatio) {
  // The same at the links of elastic joints, through torque sensors of finite bandwidth. Without
  // the correction for the joints' deflection the fast modes show 0.51.
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (const Vector6& stiffness : table_one_stiffnesses()) {
      for (int mode = 0; mode < 6; ++mode) {
        const double ratio = measured_ratio({model, pose, ideal_drives()}, stiffness, 0.7, mode);
        EXPECT_NEAR(ratio, 0.7, 0.15 * 0.7)
            << "mode " << mode << ", stiffness " << stiffness.transpose();
      }
    }
  }
}

TEST(DampingPhysics, MotorFrictionOnlyAddsDamping) {
  // Viscous friction f_v B_theta / B adds to D, and Coulomb friction f_c takes 2 f_c / (pi k x) of
  // a swing x, B_theta / B of both. Neither can make a mode livelier than commanded. How much they
  // add depends on the swing: a soft mode of 5 mm does not swing at all.
  const ArmModel model = testing::make_arm();
  const DriveDescription drives = load_lwr_drives().with_ideal_sensors();
  for (const JointVector& pose : test_poses()) {
    for (const std::size_t pair : {std::size_t{0}, std::size_t{4}, std::size_t{8}}) {
      for (int mode = 0; mode < 6; ++mode) {
        const Vector6 stiffness = table_one_stiffnesses()[pair];
        EXPECT_GT(measured_ratio({model, pose, drives}, stiffness, 0.7, mode), 0.85 * 0.7)
            << "mode " << mode << ", stiffness " << stiffness.transpose();
      }
    }
  }
}

TEST(DampingPhysics, VelocityFeedForwardRemovesTheTrackingLag) {
  // Without it a spring and damper lag by D v / K, 2 cm at 0.25 m/s. What is left with elastic
  // joints is their deflection under the acceleration: 6 kg at 8 m/s^2 on 15 kN/m are 3 mm. The
  // line is one that the joints can follow at 0.8 m/s.
  const ArmModel model = testing::make_arm();
  for (const bool elastic : {false, true}) {
    for (const JointVector& pose : test_poses()) {
      for (const double speed : {0.1, 0.25, 0.8}) {
        double worst[2] = {0.0, 0.0};
        for (const bool feed_forward : {true, false}) {
          ControlledArm arm(
              model, elastic ? ArmPlant(model, pose, ideal_drives()) : ArmPlant(model, pose));
          const CartesianTrajectory line = line_from(model, pose, {-0.05, 0.05, 0.2}, speed);
          for (double t = kControlPeriod; t < line.duration() + 0.2; t += kControlPeriod) {
            CartesianTarget target = line.sample(t);
            if (!feed_forward) target = {.T_world_tcp = target.T_world_tcp};
            arm.controller.set_cartesian_target(target);
            arm.tick();
            if (HasFatalFailure()) return;
            const double error = arm.displacement(target.T_world_tcp).head<3>().norm();
            worst[feed_forward] = std::max(worst[feed_forward], error);
          }
        }
        EXPECT_LT(worst[true], elastic ? 0.004 : 0.002) << speed << " m/s";
        EXPECT_GT(worst[false], 5.0 * worst[true]) << speed << " m/s";
      }
    }
  }
}

}  // namespace
}  // namespace binpick
