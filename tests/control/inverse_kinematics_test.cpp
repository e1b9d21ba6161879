#include "control/inverse_kinematics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/test_arm.h"
#include "models/errors.h"

namespace binpick {
namespace {

using testing::degrees;
using testing::make_arm;
using testing::random_posture;

constexpr Seed kSeed = 42;
constexpr int kPoses = 100000;

double pose_error(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

class InverseKinematicsTest : public ::testing::Test {
 protected:
  const ArmModel arm_ = make_arm();
  const InverseKinematics kinematics_{arm_};
  Random random_{kSeed};
};

TEST_F(InverseKinematicsTest, FindsEveryReachablePose) {
  IkOptions options;
  options.min_margin = 0.0;
  for (int i = 0; i < kPoses / 10; ++i) {
    const Eigen::Isometry3d wanted =
        arm_.forward_kinematics(random_posture(random_, arm_.limits()));
    const IkResult found = kinematics_.solve(wanted, JointVector::Zero(), options);
    ASSERT_TRUE(found) << "pose " << i << ": " << to_string(found.failure());
    EXPECT_LT(pose_error(arm_.forward_kinematics(found->q), wanted), 1e-9);
    EXPECT_TRUE(arm_.limits().contains(found->q));
    EXPECT_NEAR(found->margin, kinematics_.margin(found->q), 1e-12);
  }
}

TEST_F(InverseKinematicsTest, EveryBranchReachesThePoseWithinLimitsAtTheWantedSwivel) {
  std::size_t most = 0;
  for (int i = 0; i < kPoses; ++i) {
    const Eigen::Isometry3d wanted =
        arm_.forward_kinematics(random_posture(random_, arm_.limits()));
    const double swivel = random_.uniform(-std::numbers::pi, std::numbers::pi);
    const IkBranches branches = kinematics_.branches(wanted, swivel);
    most = std::max(most, branches.size());
    for (const IkSolution& branch : branches) {
      EXPECT_LT(pose_error(arm_.forward_kinematics(branch.q), wanted), 1e-9);
      EXPECT_TRUE(arm_.limits().contains(branch.q));
      EXPECT_NEAR(std::remainder(kinematics_.swivel(branch.q) - swivel, 2.0 * std::numbers::pi),
                  0.0, 1e-6);
    }
  }
  EXPECT_EQ(most, 8u);
}

TEST_F(InverseKinematicsTest, ThePostureThatMadeThePoseIsAmongTheBranchesOfItsSwivel) {
  for (int i = 0; i < kPoses; ++i) {
    const JointVector q = random_posture(random_, arm_.limits());
    const IkBranches branches =
        kinematics_.branches(arm_.forward_kinematics(q), kinematics_.swivel(q));
    const bool present = std::any_of(branches.begin(), branches.end(), [&](const IkSolution& s) {
      return (s.q - q).cwiseAbs().maxCoeff() < 1e-6;
    });
    EXPECT_TRUE(present) << q.transpose();
  }
}

TEST_F(InverseKinematicsTest, FindsNarrowIntervalsOfTheSwivelAngle) {
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d wanted =
        arm_.forward_kinematics(random_posture(random_, arm_.limits(), 0.8));
    double widest = 0.0;
    constexpr int kFine = 3600;
    for (int k = 0; k < kFine; ++k) {
      const double swivel = 2.0 * std::numbers::pi * k / kFine;
      for (const IkSolution& branch : kinematics_.branches(wanted, swivel)) {
        widest = std::max(widest, branch.margin);
      }
    }
    IkOptions options;
    options.min_margin = 0.9999 * widest;
    EXPECT_TRUE(kinematics_.solve(wanted, JointVector::Zero(), options)) << "pose " << i;
  }
}

TEST_F(InverseKinematicsTest, WorksForABaseAnywhere) {
  Eigen::Isometry3d T_world_base = Eigen::Isometry3d::Identity();
  T_world_base.translation() << 0.2, -0.4, 0.9;
  T_world_base.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -1, 2).normalized()));
  const ArmModel arm = make_arm(T_world_base);
  const InverseKinematics kinematics(arm);
  for (int i = 0; i < 100; ++i) {
    const JointVector q = random_posture(random_, arm.limits(), 0.9);
    const Eigen::Isometry3d wanted = arm.forward_kinematics(q);
    const IkResult found = kinematics.solve(wanted, q);
    ASSERT_TRUE(found);
    EXPECT_LT(pose_error(arm.forward_kinematics(found->q), wanted), 1e-9);
  }
}

TEST_F(InverseKinematicsTest, SingularPosturesAreSolvedExactly) {
  // Upper arm vertical, forearm and hand in line, wrist over the shoulder.
  for (const JointVector& q :
       {degrees(20, 0, 10, 60, 0, 0, 30), degrees(0, 0, 0, 90, 10, 0, 0),
        degrees(0, 45, 0, 90, 0, 45, 0), degrees(30, -40, 20, 0.5, 10, 30, 0)}) {
    const Eigen::Isometry3d wanted = arm_.forward_kinematics(q);
    IkOptions options;
    options.min_margin = 0.0;
    const IkResult found = kinematics_.solve(wanted, q, options);
    ASSERT_TRUE(found) << q.transpose();
    EXPECT_LT(pose_error(arm_.forward_kinematics(found->q), wanted), 1e-9) << q.transpose();
  }
}

TEST_F(InverseKinematicsTest, ReachIsWhatTheElbowAllows) {
  // a = 0.40 m, b = 0.39 m, elbow at most 120 degrees.
  EXPECT_NEAR(kinematics_.reach().low, 0.3951, 1e-4);
  EXPECT_NEAR(kinematics_.reach().high, 0.79, 1e-12);
  Eigen::Isometry3d wanted = arm_.forward_kinematics(degrees(0, -30, 0, 90, 0, -60, 0));
  const Eigen::Vector3d outward(1.0, 0.0, 0.0);
  const auto wrist_at = [&](double distance) {
    wanted.translation() +=
        kinematics_.p_world_shoulder() + distance * outward - kinematics_.p_world_wrist(wanted);
    return kinematics_.solve(wanted, JointVector::Zero());
  };
  EXPECT_EQ(wrist_at(0.791).failure(), IkFailure::kTooFar);
  EXPECT_TRUE(wrist_at(0.789));
  EXPECT_TRUE(wrist_at(0.42));
  EXPECT_EQ(wrist_at(0.394).failure(), IkFailure::kTooClose);
}

TEST_F(InverseKinematicsTest, AHandTurnedIntoTheForearmIsUnreachableForItsJointLimits) {
  // The hand points back along the arm: joint 6 would have to fold by 180 degrees.
  const JointVector stretched = degrees(0, 60, 0, 0, 0, 0, 0);
  Eigen::Isometry3d wanted = arm_.forward_kinematics(stretched);
  const Eigen::Vector3d p_wrist = kinematics_.p_world_wrist(wanted);
  const Eigen::Vector3d across = wanted.linear().col(1);
  const Eigen::AngleAxisd fold(std::numbers::pi, across);
  wanted.linear() = fold * wanted.linear();
  wanted.translation() = p_wrist + fold * (wanted.translation() - p_wrist);
  wanted.translation() *= 0.999;
  EXPECT_EQ(kinematics_.solve(wanted, stretched).failure(), IkFailure::kJointLimits);
}

TEST_F(InverseKinematicsTest, PosturesFollowALineOfPosesWithoutJumps) {
  JointVector q = degrees(0, -30, 0, 90, 0, -60, 0);
  Eigen::Isometry3d wanted = arm_.forward_kinematics(q);
  for (int i = 0; i < 100; ++i) {
    wanted.translation() += Eigen::Vector3d(0.0, 0.003, 0.001);
    const IkResult found = kinematics_.solve(wanted, q);
    ASSERT_TRUE(found);
    EXPECT_LT((found->q - q).cwiseAbs().maxCoeff(), 0.15) << "step " << i;
    q = found->q;
  }
}

TEST_F(InverseKinematicsTest, NoStepLongerThanAllowed) {
  IkOptions options;
  options.max_step = 0.5;
  int found_some = 0;
  for (int i = 0; i < 200; ++i) {
    const JointVector q = random_posture(random_, arm_.limits(), 0.9);
    const JointVector seed = random_posture(random_, arm_.limits(), 0.9);
    const IkResult far = kinematics_.solve(arm_.forward_kinematics(q), seed, options);
    if (far) {
      EXPECT_LE((far->q - seed).cwiseAbs().maxCoeff(), 0.5);
    } else {
      EXPECT_EQ(far.failure(), IkFailure::kFarFromSeed);
    }
    const IkResult near = kinematics_.solve(arm_.forward_kinematics(q), q, options);
    found_some += near ? 1 : 0;
  }
  EXPECT_EQ(found_some, 200);
}

TEST_F(InverseKinematicsTest, PrefersARaisedElbow) {
  const Eigen::Isometry3d wanted = arm_.forward_kinematics(degrees(0, -30, 0, 90, 0, -60, 0));
  const IkResult found = kinematics_.solve(wanted, JointVector::Zero());
  ASSERT_TRUE(found);
  EXPECT_LT(std::abs(found->swivel), std::numbers::pi / 3.0);
}

TEST(InverseKinematics, RefusesAnArmThatIsNotSpherical) {
  RobotDescription robot = load_lwr();
  robot.joints[3].T_parent_joint.translation().x() += 0.045;  // an elbow offset
  EXPECT_THROW(InverseKinematics(ArmModel(robot, load_gripper())), InputError);
  robot = load_lwr();
  robot.joints[5].axis = Eigen::Vector3d::UnitX();
  EXPECT_THROW(InverseKinematics(ArmModel(robot, load_gripper())), InputError);
}

}  // namespace
}  // namespace binpick
