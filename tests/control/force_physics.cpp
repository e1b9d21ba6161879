// Contact forces: the eight cases of IJRR 2012, Figs. 5 and 6. The tool goes down onto an elastic
// surface 0.1 m below it and is asked to go on for 6 cm; the paper names no stiffness: high is
// 4000 N/m, low 300 N/m. The clutch of the virtual spring is opened to 1000 N, else it would set
// the sustained force of the stiff arm.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "control/controlled_arm.h"

namespace binpick {
namespace {

constexpr double kHigh = 4000.0;
constexpr double kLow = 300.0;
constexpr double kSlow = 0.1;
constexpr double kFast = 0.8;
constexpr double kOvershoot = 0.06;

struct Contact {
  double first_peak = 0.0;  ///< N, of the first touch: until the force falls again by a tenth
  double peak = 0.0;        ///< N
  double sustained = 0.0;   ///< N, mean of the last half second
};

struct Case {
  double stiffness;  ///< N/m, of the arm along z
  double speed;      ///< m/s
  bool react;
};

Contact touch(const JointVector& pose, double surface, const Case& c, bool elastic) {
  const ArmModel model = testing::make_arm();
  ArmControllerOptions options;
  options.cartesian.stiffness << c.stiffness, c.stiffness, c.stiffness, 200, 200, 200;
  options.cartesian.max_spring_force = 1000.0;
  options.observer.gain = 100.0;
  ControlledArm arm(model, elastic ? ArmPlant(model, pose, ideal_drives()) : ArmPlant(model, pose),
                    options);
  const Eigen::Vector3d down(0, 0, -0.1 - kOvershoot);
  const CartesianTrajectory line = line_from(model, pose, down, c.speed);
  const double height = model.forward_kinematics(pose).translation().z() - 0.1;
  const ArmPlant::External ground = wall(Eigen::Vector3d::UnitZ(), height, surface);
  arm.controller.set_thresholds(
      ContactThresholds::for_phase(ContactPhase::kApproach, model.limits()));
  Contact contact;
  bool stopped = false;
  bool first = true;
  for (double t = 0.0; t < line.duration() + 1.0; t += kControlPeriod) {
    if (!stopped) arm.controller.set_cartesian_target(line.sample(t));
    arm.tick(ground);
    if (::testing::Test::HasFatalFailure()) return contact;
    const double depth = height - model.forward_kinematics(arm.plant.q()).translation().z();
    const double force = surface * std::max(depth, 0.0);
    contact.peak = std::max(contact.peak, force);
    if (first) contact.first_peak = contact.peak;
    if (force < 0.9 * contact.peak) first = false;
    if (t > line.duration() + 0.5) contact.sustained += force * kControlPeriod / 0.5;
    if (c.react && !stopped && arm.controller.status().collision) {
      arm.controller.stop();
      stopped = true;
    }
  }
  return contact;
}

/// Inertia of the tool along z at the pose of the touch, kg.
double effective_mass(const JointVector& pose, bool elastic) {
  ArmDynamics dynamics = testing::make_arm().evaluate(pose, JointVector::Zero());
  if (elastic) {
    dynamics.M.diagonal() += ElasticJoints::of(load_lwr_drives()).shaped_inertia();
  }
  const Vector6 u = Vector6::Unit(2);
  return 1.0 / (u.transpose() * dynamics.J * dynamics.M.inverse() * dynamics.J.transpose() * u)(0);
}

TEST(ForcePhysics, EightCasesComeInTheirOrder) {
  for (const bool elastic : {false, true}) {
    for (const JointVector& pose : test_poses()) {
      for (const double surface : {5e3, 3e4}) {
        const auto force = [&](double stiffness, double speed, bool react) {
          return touch(pose, surface, {stiffness, speed, react}, elastic);
        };
        const Contact stiff_fast = force(kHigh, kFast, false);
        const Contact stiff_slow = force(kHigh, kSlow, false);
        const Contact soft_fast = force(kLow, kFast, false);
        const Contact soft_slow = force(kLow, kSlow, false);
        if (HasFatalFailure()) return;
        // Where 0.8 m/s are more than the joints can, the fast peak is no higher than the slow one.
        EXPECT_GE(stiff_fast.peak, 0.95 * stiff_slow.peak);
        EXPECT_GT(stiff_slow.peak, soft_slow.peak);
        EXPECT_GT(soft_fast.peak, soft_slow.peak);

        // Sustained: the two springs in series; hence soft to stiff as their stiffnesses.
        const auto series = [&](double k) { return k * surface / (k + surface) * kOvershoot; };
        EXPECT_NEAR(stiff_slow.sustained, series(kHigh), 0.05 * series(kHigh));
        EXPECT_NEAR(soft_slow.sustained, series(kLow), 0.05 * series(kLow));

        // Detection and reaction: never a higher peak, and the sustained force of the stiff arm
        // gone.
        for (const double stiffness : {kHigh, kLow}) {
          for (const double speed : {kSlow, kFast}) {
            const Contact without = force(stiffness, speed, false);
            const Contact with = force(stiffness, speed, true);
            if (HasFatalFailure()) return;
            EXPECT_LE(with.peak, 1.05 * without.peak) << stiffness << " N/m, " << speed << " m/s";
            EXPECT_LT(with.sustained, 0.5 * series(kHigh));
          }
        }
      }
    }
  }
}

TEST(ForcePhysics, FirstPeakIsInertialAgainstAStiffSurface) {
  // v sqrt(m k), with the inertia that the tool shows along z: links and, with torque feedback, the
  // shaped motors behind the joints' springs. The surface is at least seven times stiffer than the
  // arm's own spring, which hardly matters then.
  for (const bool elastic : {false, true}) {
    for (const JointVector& pose : test_poses()) {
      for (const double surface : {3e4, 1e5}) {
        for (const double stiffness : {kLow, kHigh}) {
          if (surface < 7.0 * stiffness) continue;
          const double m = effective_mass(pose, elastic);
          const double expected = kFast * std::sqrt(m * surface);
          const Contact contact = touch(pose, surface, {stiffness, kFast, false}, elastic);
          if (HasFatalFailure()) return;
          EXPECT_NEAR(contact.first_peak, expected, 0.25 * expected)
              << (elastic ? "elastic, " : "rigid, ") << surface << " N/m, arm " << stiffness
              << " N/m, mass " << m;
        }
      }
    }
  }
}

}  // namespace
}  // namespace binpick
