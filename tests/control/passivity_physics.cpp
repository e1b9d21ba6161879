// Energy: what is stored never grows by more than the work put in from outside.
#include <gtest/gtest.h>

#include <vector>

#include "control/controlled_arm.h"

namespace binpick {
namespace {

ArmModel heavier(double factor) {
  RobotDescription robot = load_lwr();
  for (LinkDescription& link : robot.links) {
    link.inertia.mass *= factor;
    link.inertia.inertia *= factor;
  }
  return {robot, load_gripper()};
}

/// A push at tool and elbow that lasts until the next is drawn.
struct Push {
  Vector6 wrench = Vector6::Zero();
  Eigen::Vector3d elbow = Eigen::Vector3d::Zero();

  void draw(Random& random) {
    wrench << 25.0 * random.uniform() * random.unit_vector(),
        2.0 * random.uniform() * random.unit_vector();
    elbow = 15.0 * random.uniform() * random.unit_vector();
  }
  [[nodiscard]] JointVector torques(const ArmModel& model, const ArmDynamics& dynamics,
                                    const JointVector& q) const {
    return dynamics.J.transpose() * wrench + model.elbow(q).J.transpose() * elbow;
  }
};

TEST(PassivityPhysics, RigidArmWithPostureLimitsAndSwitchedStiffness) {
  // Kinetic energy, virtual spring, and what posture and limit repulsion may still spend; with a
  // model 1.5 times too heavy gravity's error is one more potential. The stiffness is switched at
  // random, and so is the posture. The tolerance is what stores that are updated once per tick,
  // with the velocity at its beginning, leave open: 2.5 mJ at 1 kHz, 0.2 mJ at 4 kHz.
  const ArmModel model = testing::make_arm();
  const ArmModel heavy = heavier(1.5);
  Random random(derive_seed(7, "pushes"));
  const std::vector<Vector6> stiffnesses = table_one_stiffnesses();
  for (const ArmModel* belief : {&model, &heavy}) {
    for (const JointVector& pose : test_poses()) {
      ArmPlant plant(model, pose);
      CartesianImpedance law(model.limits(), {});
      law.start(pose);
      const CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
      Push push;
      const auto step = [&] {
        const ArmDynamics dynamics = belief->evaluate(plant.q(), plant.qd());
        const OperationalSpace space(dynamics.M, dynamics.J);
        const JointVector tau =
            law.torques(dynamics, space, plant.q(), plant.qd(), target, kControlPeriod);
        plant.step(tau + dynamics.gravity, [&](const ArmDynamics& now, const JointVector&) {
          return push.torques(model, now, plant.q());
        });
      };
      const auto stored = [&] {
        return plant.kinetic_energy() + law.spring_energy() + law.posture_store() +
               model.potential_energy(plant.q()) - belief->potential_energy(plant.q());
      };
      step();
      const double at_start = stored() - plant.external_work();
      double worst = 0.0;
      for (int i = 0; i < 6000; ++i) {
        if (i % 150 == 0) push.draw(random);
        if (i % 400 == 0) law.set_stiffness(stiffnesses[random.index(9)]);
        if (i % 700 == 0) law.set_posture(pose + testing::random_vector(random, 0.6));
        step();
        worst = std::max(worst, stored() - plant.external_work() - at_start);
      }
      EXPECT_LT(worst, 3e-3);
      EXPECT_GT(plant.external_work(), 0.1) << "the pushes did nothing";
    }
  }
}

TEST(PassivityPhysics, ElasticArmUnderTheFullLaw) {
  // Storage of Ott 2008, section 5.3, with the potential that belongs to l(qb):
  //   S = 1/2 qd M qd + 1/2 theta_d B_theta theta_d + 1/2 (theta-q) K (theta-q) + V_g(q)
  //       + V_x(qb) - V_g(qb) - 1/2 l K^-1 l,      dS/d theta = -l(qb).
  // Gravity from a model that is too heavy stays inside l, so S still bounds the work.
  const ArmModel model = testing::make_arm();
  const ArmModel heavy = heavier(1.5);
  const ElasticJoints joints = ElasticJoints::of(load_lwr_drives());
  Random random(derive_seed(7, "elastic pushes"));
  for (const double friction : {0.0, 1.0}) {
    for (const ArmModel* belief : {&model, &heavy}) {
      for (const JointVector& pose : test_poses()) {
        ArmControllerOptions options;
        options.cartesian.posture_stiffness = 0.0;  // has no potential; above it has its store
        options.cartesian.limit_stiffness = 0.0;
        const DriveDescription drives =
            load_lwr_drives().with_friction(friction).with_ideal_sensors();
        ControlledArm arm(*belief, ArmPlant(model, pose, drives), options);
        const Eigen::Isometry3d T = model.forward_kinematics(pose);
        arm.controller.set_cartesian_target({.T_world_tcp = T});
        options.cartesian.inertia_cap = joints.inertia_cap;
        CartesianImpedance probe(model.limits(), options.cartesian);
        const auto stored = [&] {
          JointVector qb = arm.plant.q();
          JointVector load = belief->gravity(qb);
          double spring = 0.0;
          for (int i = 0; i < 12; ++i) {
            qb = arm.plant.theta() - load.cwiseQuotient(joints.stiffness);
            ArmDynamics at = belief->evaluate(qb, JointVector::Zero());
            at.M.diagonal() += joints.shaped_inertia();
            const OperationalSpace space(at.M, at.J, joints.inertia_cap);
            load = at.gravity + probe.static_torques(at, space, qb, T);
            (void)probe.torques(at, space, qb, JointVector::Zero(), {.T_world_tcp = T}, 1e-3);
            spring = probe.spring_energy();
          }
          const JointVector twist = arm.plant.theta() - arm.plant.q();
          const JointVector& motor = arm.plant.theta_d();
          return arm.plant.kinetic_energy() +
                 0.5 * motor.dot(joints.shaped_inertia().cwiseProduct(motor)) +
                 0.5 * twist.dot(joints.stiffness.cwiseProduct(twist)) +
                 model.potential_energy(arm.plant.q()) + spring - belief->potential_energy(qb) -
                 0.5 * load.dot(load.cwiseQuotient(joints.stiffness));
        };
        arm.tick();
        const double at_start = stored() - arm.plant.external_work();
        double worst = 0.0;
        Push push;
        for (int i = 0; i < 2000; ++i) {
          if (i % 150 == 0) push.draw(random);
          arm.tick([&](const ArmDynamics& now, const JointVector&) {
            return push.torques(model, now, arm.plant.q());
          });
          if (HasFatalFailure()) return;
          worst = std::max(worst, stored() - arm.plant.external_work() - at_start);
        }
        EXPECT_LT(worst, 1e-4) << "friction " << friction;
        EXPECT_GT(arm.plant.external_work(), 0.05) << "the pushes did nothing";
      }
    }
  }
}

TEST(PassivityPhysics, SwitchingTheStiffnessOfAStretchedSpringGivesNothingAway) {
  // The tool is held 4 cm from its target while the stiffness is asked up and down a hundred times.
  const ArmModel model = testing::make_arm();
  for (const JointVector& pose : test_poses()) {
    ArmPlant plant(model, pose);
    CartesianImpedance law(model.limits(), {});
    law.start(pose);
    CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
    target.T_world_tcp.translation() += 0.04 * target.T_world_tcp.linear().col(1);
    const std::vector<Vector6> stiffnesses = table_one_stiffnesses();
    const auto step = [&] {
      const ArmDynamics dynamics = plant.dynamics();
      const OperationalSpace space(dynamics.M, dynamics.J);
      const JointVector tau =
          law.torques(dynamics, space, plant.q(), plant.qd(), target, kControlPeriod);
      Vector6 hold = Vector6::Zero();
      hold.head<3>() = -law.spring_wrench().head<3>() - 200.0 * (dynamics.J * plant.qd()).head<3>();
      plant.step(tau + dynamics.gravity, wrench_at_tool(hold));
    };
    const auto stored = [&] {
      return plant.kinetic_energy() + law.spring_energy() + law.posture_store();
    };
    law.set_stiffness(stiffnesses.front());
    for (int i = 0; i < 1000; ++i) step();
    const double at_start = stored() + law.energy_store() - plant.external_work();
    double worst = 0.0;
    for (int i = 0; i < 5000; ++i) {
      if (i % 50 == 0) law.set_stiffness(i % 100 == 0 ? stiffnesses.back() : stiffnesses.front());
      step();
      worst = std::max(worst, stored() - plant.external_work() - at_start);
    }
    EXPECT_LT(worst, 1e-4);
  }
}

}  // namespace
}  // namespace binpick
