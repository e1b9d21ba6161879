#include "control/operational_space.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "control/arm_plant.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

TEST(OperationalSpace, AgreesWithDenseLinearAlgebra) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    const ArmDynamics dynamics = model.evaluate(pose, JointVector::Zero());
    const OperationalSpace space(dynamics.M, dynamics.J);
    const JointMatrix M_inverse = dynamics.M.inverse();
    const Matrix6 inverse = dynamics.J * M_inverse * dynamics.J.transpose();
    EXPECT_LT((space.lambda_inverse() - inverse).norm(), 1e-9 * inverse.norm());
    EXPECT_FALSE(space.near_singularity());

    const Vector6 y = Vector6::LinSpaced(-1.0, 2.0);
    const Vector6 lambda_y = inverse.inverse() * y;
    EXPECT_LT((space.lambda_times(y) - lambda_y).norm(), 1e-8 * lambda_y.norm());

    const JointVector tau = JointVector::LinSpaced(3.0, -5.0);
    const Vector6 wrench = inverse.inverse() * dynamics.J * M_inverse * tau;
    EXPECT_LT((space.wrench_of(tau) - wrench).norm(), 1e-8 * wrench.norm());
    EXPECT_LT((dynamics.J * M_inverse * space.null_space_part(tau)).norm(), 1e-8);
  }
}

TEST(OperationalSpace, WrenchOfToolForceIsThatForce) {
  const ArmModel model = testing::make_arm();
  const Vector6 force = (Vector6() << 3, -7, 15, 0.2, -0.4, 0.1).finished();
  for (const JointVector& pose : test_poses()) {
    const ArmDynamics dynamics = model.evaluate(pose, JointVector::Zero());
    const OperationalSpace space(dynamics.M, dynamics.J);
    EXPECT_LT((space.wrench_of(dynamics.J.transpose() * force) - force).norm(), 1e-8);
  }
}

TEST(OperationalSpace, CapHoldsAtSingularities) {
  // Stretched upwards, the arm cannot move along z.
  const ArmModel model = testing::make_arm();
  const ArmDynamics dynamics = model.evaluate(JointVector::Zero(), JointVector::Zero());
  const InertiaCap cap{.mass = 50.0, .inertia = 5.0};
  const OperationalSpace space(dynamics.M, dynamics.J, cap);
  EXPECT_TRUE(space.near_singularity());
  EXPECT_LT(space.lambda_times(Vector6::Unit(2)).norm(), 2.0 * cap.mass);
}

}  // namespace
}  // namespace binpick
