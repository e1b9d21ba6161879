#include "control/arm_model.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "control/test_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

using testing::degrees;
using testing::make_arm;
using testing::make_bare_arm;
using testing::random_posture;
using testing::random_vector;
using testing::rotation_between;

constexpr Seed kSeed = 20260101;
constexpr int kPostures = 100;

double kinetic_energy(const ArmModel& arm, const JointVector& q, const JointVector& qd) {
  return 0.5 * qd.dot(arm.evaluate(q, qd).M * qd);
}

// Gaz, Flacco and De Luca (ICRA 2016): the identified model in this posture.
TEST(ArmModel, StretchedArmHasThePublishedGravityAndInertia) {
  const ArmModel arm = make_bare_arm();
  const ArmDynamics dynamics = arm.evaluate(degrees(0, 90, 0, 0, 0, 0, 0), JointVector::Zero());
  EXPECT_NEAR(dynamics.gravity[1], -47.3, 0.1);
  EXPECT_NEAR(dynamics.gravity[3], 13.4, 0.05);
  JointVector published;
  published << 2.80, 2.79, 0.017, 0.444, 0.006, 0.004, 0.0001;
  const JointVector tolerance =
      (JointVector() << 0.0063, 0.0063, 0.0063, 0.0063, 0.0063, 0.0063, 0.0063).finished();
  for (int i = 0; i < kArmJoints; ++i) {
    EXPECT_NEAR(dynamics.M(i, i), published[i], tolerance[i]) << "joint " << i + 1;
  }
}

TEST(ArmModel, UprightArmHasTheDataSheetLengths) {
  const ArmModel arm = make_bare_arm();
  const auto poses = arm.link_poses(JointVector::Zero());
  EXPECT_NEAR(poses[2].translation().z(), 0.31, 1e-12);         // shoulder
  EXPECT_NEAR(poses[4].translation().z(), 0.31 + 0.40, 1e-12);  // elbow
  EXPECT_NEAR(poses[6].translation().z(), 1.10, 1e-12);         // wrist
  EXPECT_NEAR(arm.forward_kinematics(JointVector::Zero()).translation().z(), 1.178, 1e-12);
}

TEST(ArmModel, SecondJointTipsTheArmBackwardsForPositiveAngles) {
  const Eigen::Vector3d p =
      make_bare_arm().forward_kinematics(degrees(0, 90, 0, 0, 0, 0, 0)).translation();
  EXPECT_NEAR((p - Eigen::Vector3d(-0.868, 0.0, 0.31)).norm(), 0.0, 1e-12);
}

TEST(ArmModel, MassMatrixIsSymmetricAndPositiveDefinite) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  for (int i = 0; i < kPostures; ++i) {
    const ArmDynamics dynamics =
        arm.evaluate(random_posture(random, arm.limits()), JointVector::Zero());
    EXPECT_EQ((dynamics.M - dynamics.M.transpose()).norm(), 0.0);
    EXPECT_EQ(Eigen::LLT<JointMatrix>(dynamics.M).info(), Eigen::Success);
  }
}

TEST(ArmModel, MassRateIsCoriolisPlusItsTranspose) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const JointVector qd = random_vector(random, 2.0);
    const ArmDynamics now = arm.evaluate(q, qd);
    const JointMatrix M_dot =
        (arm.evaluate(q + kStep * qd, qd).M - arm.evaluate(q - kStep * qd, qd).M) / (2.0 * kStep);
    EXPECT_LT((M_dot * qd - now.coriolis - now.coriolis_transposed).norm(), 1e-7);
    // qd^T (M_dot - 2 C) qd = 0
    EXPECT_NEAR(qd.dot(M_dot * qd) - 2.0 * qd.dot(now.coriolis), 0.0, 1e-7);
  }
}

TEST(ArmModel, TransposedCoriolisIsTheGradientOfTheKineticEnergy) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const JointVector qd = random_vector(random, 2.0);
    const ArmDynamics now = arm.evaluate(q, qd);
    for (int j = 0; j < kArmJoints; ++j) {
      const JointVector step = kStep * JointVector::Unit(j);
      const double slope =
          (kinetic_energy(arm, q + step, qd) - kinetic_energy(arm, q - step, qd)) / (2.0 * kStep);
      EXPECT_NEAR(now.coriolis_transposed[j], slope, 1e-8);
    }
  }
}

TEST(ArmModel, GravityIsTheGradientOfThePotentialEnergy) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const JointVector g = arm.gravity(q);
    for (int j = 0; j < kArmJoints; ++j) {
      const JointVector step = kStep * JointVector::Unit(j);
      const double slope =
          (arm.potential_energy(q + step) - arm.potential_energy(q - step)) / (2.0 * kStep);
      EXPECT_NEAR(g[j], slope, 1e-7);
    }
  }
}

TEST(ArmModel, JacobianMatchesFiniteDifferencesOfThePose) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const Jacobian J = arm.jacobian(q);
    for (int j = 0; j < kArmJoints; ++j) {
      const JointVector step = kStep * JointVector::Unit(j);
      const Eigen::Isometry3d after = arm.forward_kinematics(q + step);
      const Eigen::Isometry3d before = arm.forward_kinematics(q - step);
      const Eigen::Vector3d linear = (after.translation() - before.translation()) / (2.0 * kStep);
      const Eigen::Vector3d angular =
          rotation_between(before.linear(), after.linear()) / (2.0 * kStep);
      EXPECT_LT((J.col(j).head<3>() - linear).norm(), 1e-8);
      EXPECT_LT((J.col(j).tail<3>() - angular).norm(), 1e-8);
    }
  }
}

TEST(ArmModel, JacobianRateMatchesFiniteDifferences) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const JointVector qd = random_vector(random, 2.0);
    const Jacobian slope =
        (arm.jacobian(q + kStep * qd) - arm.jacobian(q - kStep * qd)) / (2.0 * kStep);
    EXPECT_LT((arm.evaluate(q, qd).J_dot - slope).norm(), 1e-8);
  }
}

TEST(ArmModel, ElbowJacobianMatchesFiniteDifferences) {
  const ArmModel arm = make_arm();
  Random random(kSeed);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const PointKinematics elbow = arm.elbow(q);
    EXPECT_LT((elbow.p_world - arm.link_poses(q)[4].translation()).norm(), 1e-12);
    for (int j = 0; j < kArmJoints; ++j) {
      const JointVector step = kStep * JointVector::Unit(j);
      const Eigen::Vector3d slope =
          (arm.elbow(q + step).p_world - arm.elbow(q - step).p_world) / (2.0 * kStep);
      EXPECT_LT((elbow.J.col(j) - slope).norm(), 1e-8);
    }
  }
}

TEST(ArmModel, OnePassAgreesWithTheSingleQueries) {
  Eigen::Isometry3d T_world_base = Eigen::Isometry3d::Identity();
  T_world_base.translation() << 0.3, -0.2, 0.7;
  T_world_base.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()));
  const ArmModel arm = make_arm(T_world_base);
  Random random(kSeed);
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const ArmDynamics all = arm.evaluate(q, random_vector(random, 1.0));
    EXPECT_LT((all.J - arm.jacobian(q)).norm(), 1e-12);
    EXPECT_LT((all.gravity - arm.gravity(q)).norm(), 1e-12);
    EXPECT_LT((all.T_world_tcp.matrix() - arm.forward_kinematics(q).matrix()).norm(), 1e-12);
  }
}

TEST(ArmModel, ATurnedAndMovedBaseChangesOnlyTheWorldAxes) {
  Eigen::Isometry3d T_world_base = Eigen::Isometry3d::Identity();
  T_world_base.translation() << 0.5, -1.2, 0.7;
  T_world_base.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()));
  const ArmModel arm = make_arm();
  const ArmModel moved = make_arm(T_world_base);
  Random random(kSeed);
  const JointVector q = random_posture(random, arm.limits());
  const JointVector qd = random_vector(random, 2.0);
  const ArmDynamics a = arm.evaluate(q, qd);
  const ArmDynamics b = moved.evaluate(q, qd);
  EXPECT_LT((a.M - b.M).norm(), 1e-12);
  EXPECT_LT((a.coriolis - b.coriolis).norm(), 1e-12);
  EXPECT_LT((a.gravity - b.gravity).norm(), 1e-12);
  EXPECT_LT((T_world_base.linear() * a.J.topRows<3>() - b.J.topRows<3>()).norm(), 1e-12);
  EXPECT_LT(((T_world_base * a.T_world_tcp).matrix() - b.T_world_tcp.matrix()).norm(), 1e-12);
}

TEST(ArmModel, APointPayloadAddsItsOwnWeightAndInertia) {
  const ArmModel arm = make_arm();
  constexpr double kMass = 1.1;
  const ArmModel loaded =
      arm.with_payload({kMass, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()});
  Random random(kSeed);
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(random, arm.limits());
    const JointVector qd = random_vector(random, 2.0);
    const ArmDynamics before = arm.evaluate(q, qd);
    const ArmDynamics after = loaded.evaluate(q, qd);
    const PointJacobian J = before.J.topRows<3>();
    const PointJacobian J_dot = before.J_dot.topRows<3>();
    EXPECT_LT((after.M - before.M - kMass * J.transpose() * J).norm(), 1e-10);
    EXPECT_LT((after.gravity - before.gravity - 9.81 * kMass * J.row(2).transpose()).norm(), 1e-10);
    EXPECT_LT((after.coriolis - before.coriolis - kMass * J.transpose() * (J_dot * qd)).norm(),
              1e-10);
  }
}

TEST(ArmModel, TheUnforcedArmKeepsItsEnergy) {
  const ArmModel arm = make_arm();
  struct State {
    JointVector q;
    JointVector qd;
  };
  const auto rate = [&](const State& state) {
    const ArmDynamics dynamics = arm.evaluate(state.q, state.qd);
    const JointVector force = -dynamics.coriolis - dynamics.gravity;
    return State{state.qd, dynamics.M.llt().solve(force)};
  };
  const auto moved = [](const State& state, const State& change, double step) {
    return State{state.q + step * change.q, state.qd + step * change.qd};
  };
  State state{degrees(10, 40, -20, -60, 15, 30, 0), JointVector::Zero()};
  const double start = arm.potential_energy(state.q);
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 5000; ++i) {  // Runge-Kutta, fourth order
    const State k1 = rate(state);
    const State k2 = rate(moved(state, k1, 0.5 * kStep));
    const State k3 = rate(moved(state, k2, 0.5 * kStep));
    const State k4 = rate(moved(state, k3, kStep));
    state.q += kStep / 6.0 * (k1.q + 2.0 * k2.q + 2.0 * k3.q + k4.q);
    state.qd += kStep / 6.0 * (k1.qd + 2.0 * k2.qd + 2.0 * k3.qd + k4.qd);
  }
  const double kinetic = kinetic_energy(arm, state.q, state.qd);
  EXPECT_GT(kinetic, 5.0);  // it did fall
  EXPECT_NEAR(arm.potential_energy(state.q) + kinetic, start, 1e-6);
}

TEST(ArmModel, CombinedBodiesHaveTheSumOfMomentsAboutAnyPoint) {
  const BodyInertia a{2.0, {0.1, 0.0, 0.2}, Eigen::Vector3d(0.01, 0.02, 0.015).asDiagonal()};
  const BodyInertia b{0.5, {-0.3, 0.1, 0.0}, Eigen::Vector3d(0.001, 0.002, 0.0015).asDiagonal()};
  const BodyInertia sum = combine(a, b);
  const auto about_z_at_origin = [](const BodyInertia& body) {
    return body.inertia(2, 2) + body.mass * body.com.head<2>().squaredNorm();
  };
  EXPECT_DOUBLE_EQ(sum.mass, 2.5);
  EXPECT_NEAR((sum.mass * sum.com - a.mass * a.com - b.mass * b.com).norm(), 0.0, 1e-15);
  EXPECT_NEAR(about_z_at_origin(sum), about_z_at_origin(a) + about_z_at_origin(b), 1e-15);
}

TEST(ArmModel, RefusesWhatNoArmCanBe) {
  const GripperDescription gripper = load_gripper();
  RobotDescription robot = load_lwr();
  robot.links[3].inertia.inertia(0, 0) = 10.0;  // more than the other two together
  EXPECT_THROW(ArmModel(robot, gripper), InputError);
  robot = load_lwr();
  robot.joints[2].axis *= 2.0;
  EXPECT_THROW(ArmModel(robot, gripper), InputError);
  robot = load_lwr();
  robot.joints[5].lower = robot.joints[5].upper;
  EXPECT_THROW(ArmModel(robot, gripper), InputError);
  EXPECT_THROW((void)make_arm().with_payload({-0.1, {}, Eigen::Matrix3d::Zero()}), InputError);
}

}  // namespace
}  // namespace binpick
