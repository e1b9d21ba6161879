// Detection: no false alarm, no missed collision, latency.
#include <gtest/gtest.h>

#include <vector>

#include "control/controlled_arm.h"
#include "control/joint_trajectory.h"

namespace binpick {
namespace {

constexpr double kThreshold = 15.0;  // N
constexpr double kGain = 50.0;       // 1/s, of the observer

TEST(CollisionPhysics, NoFalseAlarmInFastFreeMotions) {
  // 200 motions with torque noise, each with its own 3 % error of every link's mass. Joint motions
  // across the whole workspace at 90 % of the speed limits, singular poses on the way included,
  // and lines at 0.8 m/s alternate. No alarm in 200: less than 1.5 % with 95 % confidence.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "free motions"));
  const std::vector<JointVector> poses = test_poses();
  int alarms = 0;
  double fastest = 0.0;
  for (int motion = 0; motion < 200; ++motion) {
    const bool joint_motion = motion % 2 == 0;
    JointVector from = poses[random.index(poses.size())] + testing::random_vector(random, 0.2);
    if (joint_motion) from = testing::random_posture(random, model.limits(), 0.9);
    const JointVector to = testing::random_posture(random, model.limits(), 0.9);
    const JointTrajectory joints({from, to}, model.limits(), {.speed = 0.9});
    const CartesianTrajectory line = line_from(model, from, 0.2 * random.unit_vector(), 0.8);
    ControlledArm arm(model, wrong_masses(0.03, random), from);
    arm.torque_noise = 0.1;
    // Some lines at 0.8 m/s ask a joint for far more than its limit.
    const double duration = (joint_motion ? joints.duration() : line.duration()) + 0.1;
    for (double t = kControlPeriod; t < duration; t += kControlPeriod) {
      if (joint_motion) {
        arm.controller.set_joint_target(joints.sample(t));
      } else {
        arm.controller.set_cartesian_target(line.sample(t));
      }
      arm.tick();
      if (HasFatalFailure()) return;
      if (arm.controller.status().collision) {
        ++alarms;
        break;
      }
    }
    fastest = std::max(fastest, arm.fastest);
  }
  EXPECT_EQ(alarms, 0);
  RecordProperty("fastest", std::to_string(fastest));
}

TEST(CollisionPhysics, NoFalseAlarmWithElasticJointsAndOffsetSensors) {
  // Friction, noise and offsets as in the drives' description; the offsets are calibrated first.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "elastic free motions"));
  const std::vector<JointVector> poses = test_poses();
  for (Seed trial = 0; trial < 6; ++trial) {
    const JointVector& from = poses[trial % poses.size()];
    ControlledArm arm(model, ArmPlant(wrong_masses(0.03, random), from, load_lwr_drives(), trial));
    arm.run(0.3);
    arm.controller.zero_observer();
    const JointTrajectory joints({from, poses[(trial + 1) % poses.size()]}, model.limits(),
                                 {.speed = 0.9});
    for (double t = kControlPeriod; t < joints.duration() + 0.1; t += kControlPeriod) {
      arm.controller.set_joint_target(joints.sample(t));
      arm.tick();
      ASSERT_FALSE(arm.controller.status().collision) << "trial " << trial << " at " << t << " s";
      if (HasFatalFailure()) return;
    }
  }
}

/// The tool going straight into a wall 0.1 m ahead, and 6 cm past it.
struct Impact {
  bool detected = false;
  double latency = INFINITY;  ///< from the first touch to hf1, s
};
Impact run_into_wall(const JointVector& pose, const Eigen::Vector3d& direction, double speed,
                     double stiffness, ControlledArm& arm) {
  const ArmModel& model = arm.plant.model();
  const CartesianTrajectory line = line_from(arm.controller.model(), pose, 0.16 * direction, speed);
  const double plane = -direction.dot(model.forward_kinematics(pose).translation()) - 0.1;
  const ArmPlant::External obstacle = wall(-direction, plane, stiffness);
  arm.controller.set_thresholds(
      ContactThresholds::for_phase(ContactPhase::kApproach, model.limits()));
  Impact impact;
  double touched = INFINITY;
  for (double t = 0.0; t < line.duration() + 0.3; t += kControlPeriod) {
    arm.controller.set_cartesian_target(line.sample(t));
    arm.tick(obstacle);
    if (::testing::Test::HasFatalFailure()) return impact;
    const Eigen::Vector3d p = model.forward_kinematics(arm.plant.q()).translation();
    if (-direction.dot(p) < plane) touched = std::min(touched, t);
    if (!arm.controller.status().collision) continue;
    impact.detected = std::isfinite(touched);
    impact.latency = t - touched;
    break;
  }
  return impact;
}

TEST(CollisionPhysics, LatencyIsWhatForceGrowthAndObserverAllow) {
  // The contact force grows by k v a second; the observer follows it within 2 / K_O.
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    double before = INFINITY;
    for (const double speed : {0.1, 0.3, 0.8}) {
      ControlledArm arm(model, pose);
      const Impact impact = run_into_wall(pose, -Eigen::Vector3d::UnitZ(), speed, 3e4, arm);
      if (HasFatalFailure()) return;
      EXPECT_LE(impact.latency, kThreshold / (3e4 * speed) + 2.0 / kGain + 0.002) << speed;
      EXPECT_LE(impact.latency, before) << "not monotone in speed at " << speed;
      before = impact.latency;
    }
    before = INFINITY;
    for (const double stiffness : {5e3, 3e4, 1e5}) {
      ControlledArm arm(model, pose);
      const Impact impact = run_into_wall(pose, -Eigen::Vector3d::UnitZ(), 0.3, stiffness, arm);
      if (HasFatalFailure()) return;
      EXPECT_LE(impact.latency, kThreshold / (stiffness * 0.3) + 2.0 / kGain + 0.002) << stiffness;
      EXPECT_LE(impact.latency, before) << "not monotone in stiffness at " << stiffness;
      before = impact.latency;
    }
  }
}

TEST(CollisionPhysics, NoCollisionIsMissed) {
  // 200 collisions from all sides, 0.1 to 0.8 m/s, 5e3 to 1e5 N/m, with 3 % mass errors and noise.
  // A soft arm that is light in the direction of the wall feels the threshold only when its own
  // spring is stretched: then the force grows with the two springs in series.
  const ArmModel model = testing::make_arm();
  Random random(derive_seed(11, "collisions"));
  const std::vector<JointVector> poses = test_poses();
  int missed = 0;
  int late = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector pose =
        poses[random.index(poses.size())] + testing::random_vector(random, 0.1);
    Eigen::Vector3d direction = random.unit_vector();
    direction.z() = -std::abs(direction.z());
    const double speed = std::exp(random.uniform(std::log(0.1), std::log(0.8)));
    const double stiffness = std::exp(random.uniform(std::log(5e3), std::log(1e5)));
    ControlledArm arm(model, wrong_masses(0.03, random), pose);
    arm.torque_noise = 0.1;
    const Impact impact = run_into_wall(pose, direction, speed, stiffness, arm);
    if (HasFatalFailure()) return;
    missed += !impact.detected;
    const double series = 1.0 / (1.0 / stiffness + 1.0 / 2000.0);
    late += impact.latency > kThreshold / (series * speed) + 2.0 / kGain + 0.002;
  }
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(late, 0);
}

}  // namespace
}  // namespace binpick
