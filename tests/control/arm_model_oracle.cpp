// The arm's dynamics against orocos-kdl, an independent implementation (articulated recursions in
// link frames instead of composite bodies in world axes).
#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacdotsolver.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "control/arm_model.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

using testing::random_posture;
using testing::random_vector;

constexpr double kTolerance = 1e-9;

KDL::Vector vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame to_kdl(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d& R = T.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                        R(2, 2)),
          vector(T.translation())};
}

KDL::RigidBodyInertia to_kdl(const BodyInertia& body) {
  const Eigen::Matrix3d& I = body.inertia;
  return KDL::RigidBodyInertia(
      body.mass, vector(body.com),
      KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
}

KDL::JntArray to_kdl(const JointVector& q) {
  KDL::JntArray array(kArmJoints);
  array.data = q;
  return array;
}

KDL::Chain make_chain(const RobotDescription& robot, const GripperDescription& gripper) {
  KDL::Chain chain;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const JointDescription& joint = robot.joints[i];
    const Eigen::Vector3d axis = joint.T_parent_joint.linear() * joint.axis;
    chain.addSegment(KDL::Segment(
        KDL::Joint(vector(joint.T_parent_joint.translation()), vector(axis), KDL::Joint::RotAxis),
        to_kdl(joint.T_parent_joint), to_kdl(robot.links[i].inertia)));
  }
  const KDL::Joint fixed(KDL::Joint::Fixed);
  chain.addSegment(KDL::Segment(fixed, to_kdl(robot.T_link7_flange),
                                to_kdl(gripper.tool_inertia(gripper.stroke.centre()))));
  chain.addSegment(KDL::Segment(fixed, to_kdl(gripper.T_flange_tcp)));
  return chain;
}

class ArmModelOracle : public ::testing::Test {
 protected:
  const RobotDescription robot_ = load_lwr();
  const GripperDescription gripper_ = load_gripper();
  const ArmModel arm_{robot_, gripper_};
  const KDL::Chain chain_ = make_chain(robot_, gripper_);
  Random random_{7};
};

TEST_F(ArmModelOracle, DynamicsEqualKdl) {
  KDL::ChainDynParam oracle(chain_, KDL::Vector(0.0, 0.0, -9.81));
  KDL::JntSpaceInertiaMatrix M(kArmJoints);
  KDL::JntArray coriolis(kArmJoints);
  KDL::JntArray gravity(kArmJoints);
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random_posture(random_, arm_.limits());
    const JointVector qd = random_vector(random_, 3.0);
    ASSERT_EQ(oracle.JntToMass(to_kdl(q), M), 0);
    ASSERT_EQ(oracle.JntToCoriolis(to_kdl(q), to_kdl(qd), coriolis), 0);
    ASSERT_EQ(oracle.JntToGravity(to_kdl(q), gravity), 0);
    const ArmDynamics ours = arm_.evaluate(q, qd);
    EXPECT_LT((ours.M - M.data).cwiseAbs().maxCoeff(), kTolerance);
    EXPECT_LT((ours.coriolis - coriolis.data).cwiseAbs().maxCoeff(), kTolerance);
    EXPECT_LT((ours.gravity - gravity.data).cwiseAbs().maxCoeff(), kTolerance);
  }
}

TEST_F(ArmModelOracle, KinematicsEqualKdl) {
  KDL::ChainFkSolverPos_recursive poses(chain_);
  KDL::ChainJntToJacSolver jacobians(chain_);
  KDL::ChainJntToJacDotSolver rates(chain_);  // hybrid: base axes, point at the tool centre
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random_posture(random_, arm_.limits());
    const JointVector qd = random_vector(random_, 3.0);
    KDL::Frame frame;
    KDL::Jacobian J(kArmJoints);
    KDL::Jacobian J_dot(kArmJoints);
    ASSERT_EQ(poses.JntToCart(to_kdl(q), frame), 0);
    ASSERT_EQ(jacobians.JntToJac(to_kdl(q), J), 0);
    ASSERT_EQ(rates.JntToJacDot(KDL::JntArrayVel(to_kdl(q), to_kdl(qd)), J_dot), 0);
    const ArmDynamics ours = arm_.evaluate(q, qd);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(ours.T_world_tcp.translation()[row], frame.p[row], kTolerance);
      for (int col = 0; col < 3; ++col) {
        EXPECT_NEAR(ours.T_world_tcp.linear()(row, col), frame.M(row, col), kTolerance);
      }
    }
    EXPECT_LT((ours.J - J.data).cwiseAbs().maxCoeff(), kTolerance);
    EXPECT_LT((ours.J_dot - J_dot.data).cwiseAbs().maxCoeff(), kTolerance);
  }
}

}  // namespace
}  // namespace binpick
