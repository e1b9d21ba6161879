// What must stay bounded, safe and said: far set-points, singular poses, latency, broken sensors.
#include <gtest/gtest.h>

#include <vector>

#include "control/controlled_arm.h"
#include "control/joint_trajectory.h"

namespace binpick {
namespace {

TEST(LimitsPhysics, AFarSetPointBreaksNoLimit) {
  // 1 m away and turned by 180 degrees, from three poses and from anywhere, rigid and elastic:
  // many of the ways lead through stretched arms and against position limits. Torques, their rates,
  // joint positions and joint speeds keep their limits in every tick.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "far"));
  std::vector<JointVector> poses = test_poses();
  for (int i = 0; i < 3; ++i) {
    poses.push_back(testing::random_posture(random, model.limits(), 0.7));
  }
  for (const bool elastic : {false, true}) {
    for (const JointVector& pose : poses) {
      for (int trial = 0; trial < 4; ++trial) {
        ControlledArm arm(model,
                          elastic ? ArmPlant(model, pose, ideal_drives()) : ArmPlant(model, pose));
        arm.tick();
        CartesianTarget far{.T_world_tcp = model.forward_kinematics(pose)};
        far.T_world_tcp.translation() += 1.0 * random.unit_vector();
        far.T_world_tcp.rotate(Eigen::AngleAxisd(M_PI, random.unit_vector()));
        arm.controller.set_cartesian_target(far);
        arm.run(elastic ? 1.5 : 5.0);
        if (HasFatalFailure()) return;
        EXPECT_NE(arm.controller.status().mode, ControlMode::kSafeStop);
      }
    }
  }
}

TEST(LimitsPhysics, ALineThatAsksJointsForTooMuchBreaksNoLimit) {
  // Lines at 0.8 m/s, some of which ask a joint for more than twice its speed: the tool falls
  // behind instead.
  const ArmModel model = testing::make_arm();
  double most_asked = 0.0;
  for (const bool elastic : {false, true}) {
    for (const JointVector& pose : test_poses()) {
      for (const Eigen::Vector3d& way :
           {Eigen::Vector3d(0.0, 0.0, -0.16), Eigen::Vector3d(-0.05, 0.15, 0.1),
            Eigen::Vector3d(0.1, -0.15, -0.1)}) {
        ControlledArm arm(model,
                          elastic ? ArmPlant(model, pose, ideal_drives()) : ArmPlant(model, pose));
        const CartesianTrajectory line = line_from(model, pose, way, 0.8);
        for (double t = 0.0; t < line.duration() + 0.3; t += kControlPeriod) {
          arm.controller.set_cartesian_target(line.sample(t));
          arm.tick();
          if (HasFatalFailure()) return;
          const ArmDynamics now = arm.plant.dynamics();
          const JointVector asked =
              OperationalSpace(now.M, now.J).joint_velocity_of(line.sample(t).twist);
          most_asked = std::max(most_asked,
                                asked.cwiseAbs().cwiseQuotient(model.limits().velocity).maxCoeff());
        }
      }
    }
  }
  EXPECT_GT(most_asked, 1.5) << "the lines are too easy to show anything";
}

TEST(LimitsPhysics, AFarJointTargetBreaksNoLimit) {
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "far joints"));
  for (int trial = 0; trial < 10; ++trial) {
    const JointVector from = testing::random_posture(random, model.limits(), 0.8);
    ControlledArm arm(model, from);
    arm.tick();
    arm.controller.set_joint_target({.q = testing::random_posture(random, model.limits(), 0.9)});
    arm.run(7.0);
    if (HasFatalFailure()) return;
    EXPECT_LT(arm.plant.qd().norm(), 0.01);
  }
}

TEST(LimitsPhysics, SingularPosesAreHeldAndLeft) {
  // Stretched, with the wrist in line, and nearly so: the arm holds, yields to a push, and comes
  // out.
  const ArmModel model = testing::make_arm();
  for (const double bend : {0.0, 1e-6, 1e-3, 0.05}) {
    for (const bool elastic : {false, true}) {
      const JointVector pose = JointVector::Constant(bend);
      ControlledArm arm(model,
                        elastic ? ArmPlant(model, pose, ideal_drives()) : ArmPlant(model, pose));
      CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
      arm.controller.set_cartesian_target(target);
      arm.run(0.2);
      const Vector6 push = (Vector6() << 8, 5, -10, 0, 0.5, 0).finished();
      arm.run(0.4, wrench_at_tool(push));
      arm.run(0.4);
      target.T_world_tcp.translation() -= Eigen::Vector3d(0.0, 0.0, 0.15);
      arm.controller.set_cartesian_target(target);
      arm.run(2.0);
      if (HasFatalFailure()) return;
      EXPECT_EQ(arm.controller.status().fault, ControlFault::kNone);
      EXPECT_LT(arm.plant.qd().norm(), 0.5) << "bend " << bend;
    }
  }
}

TEST(LimitsPhysics, AMillisecondOfLatencyIsTolerated) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (const Vector6& stiffness : table_one_stiffnesses()) {
      ArmControllerOptions options;
      options.cartesian.stiffness = stiffness;
      ArmController controller(model, options);
      ArmPlant plant(model, pose);
      CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
      target.T_world_tcp.translation() += Eigen::Vector3d(0.01, 0.02, 0.0);
      controller.set_cartesian_target(target);
      JointVector late = model.gravity(pose);
      for (int i = 0; i < 2500; ++i) {
        const JointVector tau = controller.tick(plant.state(), kControlPeriod);
        plant.step(late);
        late = tau;
      }
      EXPECT_LT(plant.qd().norm(), 5e-3);
      const Eigen::Vector3d off =
          model.forward_kinematics(plant.q()).translation() - target.T_world_tcp.translation();
      EXPECT_LT(off.norm(), 1e-3);
    }
  }
}

TEST(LimitsPhysics, ABrokenSensorStopsTheArmSafelyAndIsSaid) {
  // NaN or infinity in any of the five signals, in motion; the sensor comes back after 20 ms.
  const ArmModel model = testing::make_arm();
  const std::vector<JointVector> poses = test_poses();
  for (const bool elastic : {false, true}) {
    for (int signal = 0; signal < 5; ++signal) {
      const JointVector pose = poses[static_cast<std::size_t>(signal) % poses.size()];
      ControlledArm arm(model,
                        elastic ? ArmPlant(model, pose, ideal_drives()) : ArmPlant(model, pose));
      const JointTrajectory motion({pose, poses[0] + JointVector::Constant(0.2)}, model.limits());
      for (double t = kControlPeriod; t < 0.5 * motion.duration(); t += kControlPeriod) {
        arm.controller.set_joint_target(motion.sample(t));
        arm.tick();
      }
      for (int i = 0; i < 20; ++i) {
        JointState broken = arm.plant.state();
        JointVector* const signals[] = {&broken.q, &broken.qd, &broken.tau, &broken.theta,
                                        &broken.theta_d};
        (*signals[signal])[signal] = i % 2 == 0 ? NAN : INFINITY;
        arm.tick_on(broken);
        if (HasFatalFailure()) return;
        EXPECT_EQ(arm.controller.status().mode, ControlMode::kSafeStop);
        EXPECT_EQ(arm.controller.status().fault, ControlFault::kBadState);
      }
      arm.run(1.5);
      if (HasFatalFailure()) return;
      EXPECT_EQ(arm.controller.status().mode, ControlMode::kSafeStop) << "left without a reset";
      EXPECT_LT(arm.plant.qd().norm(), 0.01);
    }
  }
}

}  // namespace
}  // namespace binpick
