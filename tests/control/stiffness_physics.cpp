// Static stiffness, friction's dead band, and the null space, with the whole controller in the
// loop.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "control/controlled_arm.h"

namespace binpick {
namespace {

/// World wrench from one in the axes of `T`.
Vector6 to_world(const Eigen::Isometry3d& T, const Vector6& wrench) {
  Vector6 result;
  result << T.linear() * wrench.head<3>(), T.linear() * wrench.tail<3>();
  return result;
}

ArmControllerOptions with_stiffness(const Vector6& stiffness) {
  ArmControllerOptions options;
  options.cartesian.stiffness = stiffness;
  return options;
}

/// 10 N or 1 Nm along one tool axis.
Vector6 unit_load(int axis) { return (axis < 3 ? 10.0 : 1.0) * Vector6::Unit(axis); }

/// Three poses by nine stiffness pairs.
class StiffnessPhysics : public ::testing::TestWithParam<int> {
 protected:
  const ArmModel model_ = testing::make_arm();
  const JointVector pose_ = test_poses()[static_cast<std::size_t>(GetParam())];
  const Eigen::Isometry3d T_world_target_ = model_.forward_kinematics(pose_);

  /// Where the tool rests under a wrench given in tool axes.
  Vector6 displacement_under(const Vector6& wrench, const Vector6& stiffness,
                             const DriveDescription& drives) {
    ControlledArm arm(model_, ArmPlant(model_, pose_, drives), with_stiffness(stiffness));
    arm.controller.set_posture(pose_);
    arm.controller.set_cartesian_target({.T_world_tcp = T_world_target_});
    const ArmPlant::External load = wrench_at_tool(to_world(T_world_target_, wrench));
    arm.run(0.3, load);
    for (double t = 0.3; t < 5.0 && arm.plant.qd().norm() > 3e-4; t += 0.1) arm.run(0.1, load);
    settled_ = arm.plant.qd().norm();
    end_ = arm.plant.q();
    return arm.displacement(T_world_target_);
  }

  double settled_ = 0.0;
  JointVector end_ = JointVector::Zero();
};

TEST_P(StiffnessPhysics, ElasticJointsLeaveTheStiffnessAsAsked) {
  // All deflection of the joints is accounted for by qb: within 2 %, cross-coupling below 3 %.
  // Translations and rotations are compared by the spring energy they hold.
  for (const Vector6& stiffness : table_one_stiffnesses()) {
    for (int axis = 0; axis < 6; ++axis) {
      const Vector6 wrench = unit_load(axis);
      const Vector6 moved = displacement_under(wrench, stiffness, ideal_drives());
      if (HasFatalFailure()) return;
      const double expected = wrench[axis] / stiffness[axis];
      EXPECT_NEAR(moved[axis], expected, 0.02 * expected)
          << "axis " << axis << ", stiffness " << stiffness.transpose() << ", speed " << settled_;
      for (int other = 0; other < 6; ++other) {
        if (other == axis) continue;
        EXPECT_LT(std::abs(moved[other]) * std::sqrt(stiffness[other]),
                  0.03 * expected * std::sqrt(stiffness[axis]))
            << "axis " << axis << " on " << other << ", stiffness " << stiffness.transpose();
      }
    }
  }
}

TEST_P(StiffnessPhysics, FrictionLeavesItsDeadBandAndNoMore) {
  // Torque feedback leaves B_theta/B of the motors' Coulomb friction f_c. At rest
  //   J^T (F - K e) + N^T tau_posture + delta = 0 with |delta| <= f_c B_theta/B, and Jbar^T N^T =
  //   0:
  // the spring's force differs from the load by Jbar^T delta.
  const DriveDescription drives = load_lwr_drives().with_ideal_sensors();
  const ElasticJoints joints = ElasticJoints::of(drives);
  double largest = 0.0;
  for (const Vector6& stiffness : table_one_stiffnesses()) {
    for (const int axis : {1, 2, 3}) {
      const Vector6 wrench = unit_load(axis);
      const Vector6 moved = displacement_under(wrench, stiffness, drives);
      if (HasFatalFailure()) return;
      ArmDynamics dynamics = model_.evaluate(end_, JointVector::Zero());
      dynamics.M.diagonal() += joints.shaped_inertia();
      const OperationalSpace space(dynamics.M, dynamics.J, joints.inertia_cap);
      Vector6 band = Vector6::Zero();
      for (int i = 0; i < kArmJoints; ++i) {
        const double left = drives.coulomb_friction[i] / joints.inertia_reduction;
        const Vector6 share = space.wrench_of(left * JointVector::Unit(i));
        band += to_world(T_world_target_.inverse(), share).cwiseAbs();
      }
      const double error = std::abs(stiffness[axis] * moved[axis] - wrench[axis]);
      EXPECT_LT(error, band[axis] + 0.05 * wrench[axis])
          << "axis " << axis << ", stiffness " << stiffness.transpose();
      largest = std::max(largest, error / wrench[axis]);
    }
  }
  EXPECT_GT(largest, 0.02) << "friction does nothing here";
}

TEST_P(StiffnessPhysics, PushOnTheElbowMovesTheToolAsStaticsSays) {
  // 30 N on the elbow move the tool by K^-1 (J_elbow Jbar)^T F, within 2 mm.
  for (const Vector6& stiffness : table_one_stiffnesses()) {
    ArmControllerOptions options = with_stiffness(stiffness);
    options.cartesian.posture_stiffness = 100.0;
    options.cartesian.posture_energy = 20.0;
    ControlledArm arm(model_, model_, pose_, options);
    arm.controller.set_posture(pose_);
    arm.controller.set_cartesian_target({.T_world_tcp = T_world_target_});
    const Eigen::Vector3d force = Eigen::Vector3d(0.0, 30.0, 0.0);
    const auto push = [&](const ArmDynamics&, const JointVector&) {
      return JointVector(model_.elbow(arm.plant.q()).J.transpose() * force);
    };
    arm.run(2.5, push);
    if (HasFatalFailure()) return;
    const ArmDynamics dynamics = arm.plant.dynamics();
    const OperationalSpace space(dynamics.M, dynamics.J);
    const Vector6 wrench = space.wrench_of(push(dynamics, arm.plant.qd()));
    const Eigen::Vector3d expected = (T_world_target_.linear().transpose() * wrench.head<3>())
                                         .cwiseQuotient(stiffness.head<3>());
    EXPECT_LT((arm.displacement(T_world_target_).head<3>() - expected).norm(), 0.002)
        << stiffness.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Poses, StiffnessPhysics, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace binpick
