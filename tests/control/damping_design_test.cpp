#include "control/damping_design.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "control/arm_plant.h"
#include "control/test_arm.h"
#include "models/random.h"

namespace binpick {
namespace {

/// Double diagonalisation by Eigen's generalised eigenproblem.
Matrix6 reference_damping(const Vector6& K, const Matrix6& Lambda, double zeta) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> modes(Matrix6(K.asDiagonal()), Lambda);
  const Matrix6 Q_inverse = modes.eigenvectors().inverse();
  const Vector6 d = 2.0 * zeta * modes.eigenvalues().cwiseSqrt();
  return Q_inverse.transpose() * d.asDiagonal() * Q_inverse;
}

Matrix6 tool_inertia(const ArmModel& model, const JointVector& q) {
  const ArmDynamics dynamics = model.evaluate(q, JointVector::Zero());
  return (dynamics.J * dynamics.M.inverse() * dynamics.J.transpose()).inverse();
}

const Vector6 kNoCap = Vector6::Constant(1e9);

TEST(DampingDesign, AgreesWithTheGeneralisedEigenproblem) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (const Vector6& K : table_one_stiffnesses()) {
      const Matrix6 Lambda = tool_inertia(model, pose);
      DampingDesign<6> design;
      const Matrix6 D = design.from_inverse_inertia(K, Lambda.inverse(), 0.7, kNoCap);
      const Matrix6 expected = reference_damping(K, Lambda, 0.7);
      EXPECT_LT((D - expected).norm(), 1e-6 * expected.norm());
    }
  }
}

TEST(DampingDesign, WhatItRemembersDoesNotChangeTheResult) {
  // 20 000 ticks of a fast motion with stiffness jumps: a fresh design agrees at every 100th.
  const ArmModel model = testing::make_arm();
  const std::vector<Vector6> stiffnesses = table_one_stiffnesses();
  DampingDesign<6> design;
  const JointVector middle = test_poses()[1];
  for (std::size_t i = 0; i < 20000; ++i) {
    JointVector q = middle;
    for (int j = 0; j < kArmJoints; ++j) {
      q[j] += 0.5 * std::sin((1.0 + 0.3 * j) * 1e-3 * static_cast<double>(i) * 3.0);
    }
    const ArmDynamics dynamics = model.evaluate(q, JointVector::Zero());
    const OperationalSpace space(dynamics.M, dynamics.J);
    const Vector6& K = stiffnesses[(i / 500) % 9];
    const Matrix6 D = design.from_inverse_inertia(K, space.lambda_inverse(), 0.7, kNoCap);
    if (i % 100 != 0) continue;
    DampingDesign<6> fresh;
    const Matrix6 expected = fresh.from_inverse_inertia(K, space.lambda_inverse(), 0.7, kNoCap);
    ASSERT_LT((D - expected).norm(), 1e-6 * expected.norm()) << "tick " << i;
  }
}

TEST(DampingDesign, JointSpaceDampingIsTheGeometricMean) {
  // D M^-1 D = 4 zeta^2 K characterises it.
  const ArmModel model = testing::make_arm();
  const JointVector K = (JointVector() << 1500, 1500, 1000, 1000, 600, 300, 300).finished();
  for (const JointVector& pose : test_poses()) {
    const JointMatrix M = model.evaluate(pose, JointVector::Zero()).M;
    DampingDesign<7> design;
    const JointMatrix D = design.from_inertia(K, M, 0.8);
    const JointMatrix squared = D * M.inverse() * D / (4.0 * 0.8 * 0.8);
    EXPECT_LT((squared - JointMatrix(K.asDiagonal())).norm(), 1e-5 * K.norm());
  }
}

TEST(DampingDesign, CapBoundsTheDampingOfSingularDirections) {
  Vector6 inverse = Vector6::Ones();
  inverse[2] = 0.0;  // cannot move along z: infinite inertia
  const Vector6 K = Vector6::Constant(2000.0);
  DampingDesign<6> design;
  const Matrix6 D =
      design.from_inverse_inertia(K, inverse.asDiagonal(), 0.5, Vector6::Constant(50.0));
  EXPECT_NEAR(D(2, 2), std::sqrt(2000.0 * 50.0), 1e-6);
  EXPECT_NEAR(D(0, 0), std::sqrt(2000.0), 1e-6);
}

}  // namespace
}  // namespace binpick
