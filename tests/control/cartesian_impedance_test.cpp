#include "control/cartesian_impedance.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "control/arm_plant.h"
#include "control/cartesian_trajectory.h"
#include "control/test_arm.h"
#include "models/errors.h"
#include "models/random.h"

namespace binpick {
namespace {

/// Runs the law on the plant, gravity added.
class ImpedanceLoop {
 public:
  ImpedanceLoop(const ArmModel& controller_model, const ArmModel& plant_model, const JointVector& q,
                const CartesianImpedanceOptions& options)
      : model_(controller_model), law(model_.limits(), options), plant(plant_model, q) {
    law.start(q);
    target.T_world_tcp = model_.forward_kinematics(q);
  }
  ImpedanceLoop(const ArmModel& model, const JointVector& q,
                const CartesianImpedanceOptions& options = {})
      : ImpedanceLoop(model, model, q, options) {}

  void step(const ArmPlant::External& external = wrench_at_tool(Vector6::Zero()),
            double dt = kControlPeriod) {
    const ArmDynamics dynamics = model_.evaluate(plant.q(), plant.qd());
    const OperationalSpace space(dynamics.M, dynamics.J);
    const JointVector tau =
        law.torques(dynamics, space, plant.q(), plant.qd(), target, dt) + dynamics.gravity;
    plant.step(tau, external, dt);
  }
  void run(double seconds, const ArmPlant::External& external) {
    for (int i = 0; i < static_cast<int>(seconds / kControlPeriod); ++i) step(external);
  }

  /// Of the tool from the target, target axes: m and the rotation vector.
  [[nodiscard]] Vector6 displacement() const {
    const Eigen::Isometry3d T = target.T_world_tcp.inverse() * model_.forward_kinematics(plant.q());
    const Eigen::AngleAxisd rotation(T.linear());
    Vector6 result;
    result << T.translation(), rotation.angle() * rotation.axis();
    return result;
  }

 private:
  ArmModel model_;

 public:
  CartesianImpedance law;
  ArmPlant plant;
  CartesianTarget target;
};

/// World wrench from one in the axes of `T`.
Vector6 to_world(const Eigen::Isometry3d& T, const Vector6& wrench) {
  Vector6 result;
  result << T.linear() * wrench.head<3>(), T.linear() * wrench.tail<3>();
  return result;
}

TEST(CartesianImpedance, StaticStiffnessIsAsAskedOnEveryAxis) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    for (const Vector6& stiffness : table_one_stiffnesses()) {
      CartesianImpedanceOptions options;
      options.stiffness = stiffness;
      for (int axis = 0; axis < 6; ++axis) {
        ImpedanceLoop loop(model, pose, options);
        Vector6 wrench = Vector6::Zero();
        wrench[axis] = axis < 3 ? 10.0 : 1.0;
        loop.run(1.5, wrench_at_tool(to_world(loop.target.T_world_tcp, wrench)));
        const Vector6 moved = loop.displacement();
        const double expected = wrench[axis] / stiffness[axis];
        EXPECT_NEAR(moved[axis], expected, 0.02 * expected)
            << "axis " << axis << ", stiffness " << stiffness.transpose();
        // Translations and rotations are compared by the spring energy they hold.
        for (int other = 0; other < 6; ++other) {
          if (other == axis) continue;
          EXPECT_LT(std::abs(moved[other]) * std::sqrt(stiffness[other]),
                    0.03 * expected * std::sqrt(stiffness[axis]))
              << "axis " << axis << " on " << other << ", stiffness " << stiffness.transpose();
        }
      }
    }
  }
}

TEST(CartesianImpedance, EveryModeHasTheCommandedDampingRatio) {
  const ArmModel model = testing::make_arm();
  for (const double zeta : {0.4, 0.7}) {
    for (const JointVector& pose : test_poses()) {
      for (int mode = 0; mode < 6; ++mode) {
        CartesianImpedanceOptions options;
        options.stiffness << 800, 400, 1500, 60, 40, 30;
        options.damping_ratio = zeta;
        ImpedanceLoop loop(model, pose, options);

        // A step of the set-point along one eigenvector of K v = w^2 Lambda v moves that mode
        // alone; its overshoot tells the damping ratio.
        const ArmDynamics dynamics = loop.plant.dynamics();
        const Eigen::Matrix3d R = dynamics.T_world_tcp.linear();
        Matrix6 rotate = Matrix6::Zero();
        rotate.topLeftCorner<3, 3>() = R;
        rotate.bottomRightCorner<3, 3>() = R;
        const Matrix6 K = rotate * options.stiffness.asDiagonal() * rotate.transpose();
        const Matrix6 Lambda =
            (dynamics.J * dynamics.M.inverse() * dynamics.J.transpose()).inverse();
        const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> modes(K, Lambda);
        Vector6 v = modes.eigenvectors().col(mode);
        v *= 0.01 / std::max(v.head<3>().norm(), v.tail<3>().norm());
        loop.target.T_world_tcp.translation() += v.head<3>();
        loop.target.T_world_tcp.linear() =
            Eigen::AngleAxisd(v.tail<3>().norm(), v.tail<3>().normalized()).toRotationMatrix() * R;

        const Vector6 to_mode = rotate.transpose() * Lambda * v / (v.dot(Lambda * v));
        const double frequency = std::sqrt(modes.eigenvalues()[mode]);
        double overshoot = 0.0;
        for (double t = 0.0; t < 12.0 / frequency; t += kControlPeriod) {
          loop.step();
          overshoot = std::max(overshoot, to_mode.dot(loop.displacement()));
        }
        const double log_overshoot = -std::log(overshoot);
        const double measured = log_overshoot / std::hypot(M_PI, log_overshoot);
        EXPECT_NEAR(measured, zeta, 0.15 * zeta) << "mode " << mode << " at " << frequency;
      }
    }
  }
}

TEST(CartesianImpedance, FeedForwardRemovesTheTrackingLag) {
  const ArmModel model = testing::make_arm();
  double worst = 0.0;
  double worst_without = 0.0;
  for (const bool feed_forward : {true, false}) {
    ImpedanceLoop loop(model, test_poses()[0]);
    const Eigen::Isometry3d start = loop.target.T_world_tcp;
    Eigen::Isometry3d goal = start;
    goal.translation() += Eigen::Vector3d(-0.05, 0.3, 0.1);
    goal.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
    CartesianMotionLimits limits;
    limits.linear = {0.8, 8.0, 400.0};
    const CartesianTrajectory line(start, goal, limits);
    for (double t = kControlPeriod; t < line.duration() + 0.2; t += kControlPeriod) {
      // The torques of this period lead from this state to the next set-point.
      const CartesianTarget sample = line.sample(t - kControlPeriod);
      loop.target.T_world_tcp = sample.T_world_tcp;
      if (feed_forward) {
        loop.target.twist = sample.twist;
        loop.target.acceleration = sample.acceleration;
      }
      loop.step();
      loop.target.T_world_tcp = line.sample(t).T_world_tcp;
      double& error = feed_forward ? worst : worst_without;
      error = std::max(error, loop.displacement().head<3>().norm());
    }
  }
  EXPECT_LT(worst, 0.002);
  EXPECT_GT(worst_without, 10.0 * worst);
}

TEST(CartesianImpedance, StoresNoMoreEnergyThanIsPutIn) {
  // Random pushes at tool and elbow while the stiffness is switched at random; also with a model
  // whose masses are 1.5 times too large: then gravity's error is one more potential.
  const ArmModel model = testing::make_arm();
  RobotDescription heavy_robot = load_lwr();
  for (LinkDescription& link : heavy_robot.links) {
    link.inertia.mass *= 1.5;
    link.inertia.inertia *= 1.5;
  }
  const ArmModel heavy(heavy_robot, load_gripper());
  Random random(derive_seed(7, "pushes"));
  const std::vector<Vector6> stiffnesses = table_one_stiffnesses();

  for (const ArmModel* belief : {&model, &heavy}) {
    for (const JointVector& pose : test_poses()) {
      CartesianImpedanceOptions options;
      options.posture_stiffness = 0.0;  // its projection into the null space has no potential
      options.limit_stiffness = 0.0;
      ImpedanceLoop loop(*belief, model, pose, options);
      const auto stored = [&] {
        return loop.plant.kinetic_energy() + loop.law.spring_energy() +
               model.potential_energy(loop.plant.q()) - belief->potential_energy(loop.plant.q());
      };
      loop.step();
      const double at_start = stored() - loop.plant.external_work();
      double worst = 0.0;
      ArmPlant::External push = wrench_at_tool(Vector6::Zero());
      for (int i = 0; i < 6000; ++i) {
        if (i % 150 == 0) {
          Vector6 wrench;
          wrench << 25.0 * random.uniform() * random.unit_vector(),
              2.0 * random.uniform() * random.unit_vector();
          const Eigen::Vector3d elbow_force = 15.0 * random.uniform() * random.unit_vector();
          push = [wrench, elbow_force, &model, &loop](const ArmDynamics& dynamics,
                                                      const JointVector&) {
            return JointVector(dynamics.J.transpose() * wrench +
                               model.elbow(loop.plant.q()).J.transpose() * elbow_force);
          };
        }
        if (i % 400 == 0) loop.law.set_stiffness(stiffnesses[random.index(9)]);
        loop.step(push);
        worst = std::max(worst, stored() - loop.plant.external_work() - at_start);
      }
      EXPECT_LT(worst, 1e-3);
      EXPECT_GT(loop.plant.external_work(), 0.1) << "the pushes did nothing";
    }
  }
}

TEST(CartesianImpedance, SpringIsTheGradientOfItsEnergy) {
  // Also beyond the clutch, with unequal stiffnesses and a compliance centre off the tool centre.
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[1];
  ArmDynamics dynamics = model.evaluate(pose, JointVector::Zero());
  const OperationalSpace space(dynamics.M, dynamics.J);
  Random random(derive_seed(7, "gradient"));
  int clipped = 0;
  for (int trial = 0; trial < 100; ++trial) {
    CartesianImpedanceOptions options;
    options.stiffness << 2000, 200, 700, 20, 200, 75;
    options.p_tcp_compliance_centre = 0.2 * random.unit_vector();
    CartesianImpedance law(model.limits(), options);
    CartesianTarget target;
    target.T_world_tcp = dynamics.T_world_tcp;
    target.T_world_tcp.translation() += 0.1 * random.uniform() * random.unit_vector();
    target.T_world_tcp.rotate(Eigen::AngleAxisd(2.5 * random.uniform(), random.unit_vector()));

    const auto energy_at = [&](const Eigen::Isometry3d& T_world_tcp) {
      ArmDynamics moved = dynamics;
      moved.T_world_tcp = T_world_tcp;
      (void)law.torques(moved, space, pose, JointVector::Zero(), target, kControlPeriod);
      return law.spring_energy();
    };
    constexpr double kStep = 1e-6;
    Vector6 expected;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
      Eigen::Isometry3d ahead = dynamics.T_world_tcp;
      Eigen::Isometry3d behind = dynamics.T_world_tcp;
      ahead.translation() += kStep * unit;
      behind.translation() -= kStep * unit;
      expected[axis] = -(energy_at(ahead) - energy_at(behind)) / (2.0 * kStep);
      ahead = behind = dynamics.T_world_tcp;
      ahead.linear() = Eigen::AngleAxisd(kStep, unit) * dynamics.T_world_tcp.linear();
      behind.linear() = Eigen::AngleAxisd(-kStep, unit) * dynamics.T_world_tcp.linear();
      expected[axis + 3] = -(energy_at(ahead) - energy_at(behind)) / (2.0 * kStep);
    }
    (void)energy_at(dynamics.T_world_tcp);
    EXPECT_LT((law.spring_wrench() - expected).norm(), 1e-5 * (1.0 + expected.norm()));
    const double force = law.spring_wrench().head<3>().norm();
    EXPECT_LE(force, options.max_spring_force * (1.0 + 1e-6));
    clipped += force > options.max_spring_force * (1.0 - 1e-6);
  }
  EXPECT_GT(clipped, 20);
  EXPECT_LT(clipped, 100);
}

TEST(CartesianImpedance, ComplianceCentreCouplesAsStaticsSays) {
  // Seen at the tool centre, a lateral force meets 1/K_t + L^2/K_r.
  const ArmModel model = testing::make_arm();
  CartesianImpedanceOptions options;
  options.stiffness << 2000, 750, 2000, 75, 200, 200;
  options.p_tcp_compliance_centre = Eigen::Vector3d(0, 0, -0.2);
  ImpedanceLoop loop(model, test_poses()[0], options);
  Vector6 wrench = Vector6::Zero();
  wrench.y() = 5.0;
  loop.run(2.0, wrench_at_tool(to_world(loop.target.T_world_tcp, wrench)));
  const double expected = 5.0 * (1.0 / 750.0 + 0.2 * 0.2 / 75.0);
  EXPECT_NEAR(loop.displacement().y(), expected, 0.02 * expected);
}

TEST(CartesianImpedance, NullSpaceDoesNotAccelerateTheTool) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    const JointVector qd = JointVector::LinSpaced(-0.5, 0.7);
    const ArmDynamics dynamics = model.evaluate(pose, qd);
    const OperationalSpace space(dynamics.M, dynamics.J);
    CartesianTarget target;
    target.T_world_tcp = dynamics.T_world_tcp;
    CartesianImpedanceOptions passive;
    passive.posture_stiffness = 0.0;
    passive.null_space_damping = 0.0;
    CartesianImpedance without(model.limits(), passive);
    CartesianImpedance with(model.limits(), {});
    with.set_posture(pose + JointVector::Constant(0.5));
    const JointVector difference =
        with.torques(dynamics, space, pose, qd, target, kControlPeriod) -
        without.torques(dynamics, space, pose, qd, target, kControlPeriod);
    EXPECT_GT(difference.norm(), 0.1);
    EXPECT_LT((dynamics.J * dynamics.M.llt().solve(difference)).norm(), 1e-6);
  }
}

TEST(CartesianImpedance, PushOnTheElbowMovesTheToolAsStaticsSays) {
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    CartesianImpedanceOptions options;
    options.posture_stiffness = 100.0;
    ImpedanceLoop loop(model, pose, options);
    const Eigen::Vector3d force(0, 30, 0);
    loop.run(3.0, [&](const ArmDynamics&, const JointVector&) {
      return JointVector(model.elbow(loop.plant.q()).J.transpose() * force);
    });
    const ArmDynamics dynamics = loop.plant.dynamics();
    const OperationalSpace space(dynamics.M, dynamics.J);
    const Vector6 wrench = space.wrench_of(model.elbow(loop.plant.q()).J.transpose() * force);
    const Eigen::Matrix3d R = loop.target.T_world_tcp.linear();
    const Eigen::Vector3d expected =
        (R.transpose() * wrench.head<3>()).cwiseQuotient(options.stiffness.head<3>());
    EXPECT_LT((loop.displacement().head<3>() - expected).norm(), 0.002);
  }
}

TEST(CartesianImpedance, PostureReturnsToWhereItIsPulled) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ImpedanceLoop loop(model, pose);
  JointVector posture = pose;
  posture[2] += 0.4;
  loop.law.set_posture(posture);
  const double elbow_before = model.elbow(pose).p_world.y();
  loop.run(3.0, wrench_at_tool(Vector6::Zero()));
  EXPECT_GT(std::abs(model.elbow(loop.plant.q()).p_world.y() - elbow_before), 0.02);
  EXPECT_LT(loop.displacement().head<3>().norm(), 1e-3);
}

TEST(CartesianImpedance, JointLimitsRepelTheElbow) {
  const ArmModel model = testing::make_arm();
  JointVector pose = test_poses()[0];
  CartesianImpedanceOptions options;
  options.posture_stiffness = 0.0;
  ImpedanceLoop loop(model, pose, options);
  // A steady 20 Nm at joint 3 would swivel the elbow past every limit.
  double closest = 1.0;
  for (int i = 0; i < 6000; ++i) {
    loop.step([](const ArmDynamics&, const JointVector&) {
      JointVector tau = JointVector::Zero();
      tau[2] = 20.0;
      return tau;
    });
    const JointLimits& limits = model.limits();
    closest = std::min({closest, (limits.upper - loop.plant.q()).minCoeff(),
                        (loop.plant.q() - limits.lower).minCoeff()});
  }
  EXPECT_GT(closest, 0.0);
}

TEST(CartesianImpedance, AStretchedSpringIsNotStiffenedForFree) {
  const ArmModel model = testing::make_arm();
  CartesianImpedanceOptions options;
  options.stiffness << 2000, 200, 2000, 20, 200, 200;
  ImpedanceLoop loop(model, test_poses()[0], options);
  const Vector6 stiff = (Vector6() << 2000, 2000, 2000, 200, 200, 200).finished();
  // Stretched by 4 cm and held there by a force: nothing moves, so damping has taken nothing that
  // could pay for a stiffer spring.
  loop.target.T_world_tcp.translation() += 0.04 * loop.target.T_world_tcp.linear().col(1);
  const Eigen::Vector3d force = -0.04 * 200.0 * loop.target.T_world_tcp.linear().col(1);
  Vector6 wrench = Vector6::Zero();
  wrench.head<3>() = force;
  loop.step(wrench_at_tool(wrench));
  const auto balance = [&] {
    return loop.plant.kinetic_energy() + loop.law.spring_energy() - loop.plant.external_work();
  };
  const double before = balance();
  loop.law.set_stiffness(stiff);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    loop.step(wrench_at_tool(wrench));
    worst = std::max(worst, balance() - before);
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(loop.law.stiffness()[1], 220.0);

  // Let go, the spring relaxes and the stiffness comes.
  loop.run(1.0, wrench_at_tool(Vector6::Zero()));
  EXPECT_TRUE(loop.law.stiffness().isApprox(stiff)) << loop.law.stiffness().transpose();
}

TEST(CartesianImpedance, StaysBoundedAtSingularPosesAndFarTargets) {
  const ArmModel model = testing::make_arm();
  for (const double bend : {0.0, 1e-6, 1e-3, 0.05}) {
    const JointVector pose = JointVector::Constant(bend);
    const JointVector qd = JointVector::Constant(0.1);
    const ArmDynamics dynamics = model.evaluate(pose, qd);
    const OperationalSpace space(dynamics.M, dynamics.J);
    CartesianImpedance law(model.limits(), {});
    law.start(pose);
    CartesianTarget target;
    target.T_world_tcp = dynamics.T_world_tcp;
    target.T_world_tcp.translation() += Eigen::Vector3d(1, 0, 0);
    target.T_world_tcp.rotate(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
    target.twist.setConstant(0.1);
    target.acceleration.setConstant(1.0);
    const JointVector tau = law.torques(dynamics, space, pose, qd, target, kControlPeriod);
    EXPECT_TRUE(tau.allFinite());
    EXPECT_LT(tau.norm(), 300.0) << "bend " << bend;
  }
}

TEST(CartesianImpedance, RefusesOptionsWithoutMeaning) {
  CartesianImpedanceOptions options;
  options.stiffness[2] = -1.0;
  options.damping_ratio = 0.0;
  try {
    options.validate();
    FAIL() << "accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("stiffness"), std::string::npos);
    EXPECT_NE(message.find("damping ratio"), std::string::npos);
  }
}

}  // namespace
}  // namespace binpick
