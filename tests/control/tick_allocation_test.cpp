#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>

#include "control/arm_controller.h"
#include "control/arm_plant.h"
#include "control/collision_reaction.h"
#include "control/elastic_joints.h"
#include "control/test_arm.h"

// Every allocation of this program passes here: operator new and Eigen both end in malloc. The
// sanitizers replace malloc themselves and do not want company.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

thread_local std::size_t allocations = 0;

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  ++allocations;
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}

namespace binpick {
namespace {

TEST(TickAllocation, TheCounterCounts) {
  const std::size_t before = allocations;
  const Eigen::VectorXd vector = Eigen::VectorXd::Zero(100);
  delete new double(vector[0]);
  EXPECT_GE(allocations - before, 2U);
}

TEST(TickAllocation, NeitherTickNorSettersAllocate) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  const ContactThresholds thresholds =
      ContactThresholds::for_phase(ContactPhase::kApproach, model.limits());
  ArmController controller(model);
  ArmPlant plant(model, pose);
  CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
  target.T_world_tcp.translation().x() += 0.2;
  target.twist.setConstant(0.1);
  const JointState broken{.q = JointVector::Constant(std::nan("")), .qd = {}, .tau = {}};

  const std::size_t before = allocations;
  JointVector tau;
  for (int i = 0; i < 200; ++i) {
    const JointState state{.q = pose + JointVector::Constant(1e-3 * i),
                           .qd = JointVector::Constant(0.1),
                           .tau = JointVector::Constant(0.05 * i),
                           .theta = pose};
    if (i == 20) controller.set_cartesian_target(target);
    if (i == 40) controller.set_stiffness(Vector6::Constant(100.0));
    if (i == 60) controller.set_posture(pose);
    if (i == 80) controller.set_thresholds(thresholds);
    if (i == 100) controller.stop();
    if (i == 120) controller.set_joint_target({.q = pose});
    if (i == 140) controller.zero_observer();
    if (i == 160) controller.clear_payload();
    if (i == 190) controller.reset();
    tau = controller.tick(i == 180 ? broken : state, kControlPeriod);
  }
  EXPECT_EQ(allocations - before, 0U);
  EXPECT_TRUE(tau.allFinite());
}

TEST(TickAllocation, NeitherElasticJointsNorReactionsAllocate) {
  const ArmModel model = testing::make_arm();
  const JointVector pose = test_poses()[0];
  ArmControllerOptions options;
  options.joints = ElasticJoints::of(load_lwr_drives());
  const TorqueFeedback feedback(*options.joints);
  ArmController controller(model, options);
  CollisionReaction reaction(controller);
  const CartesianTarget target{.T_world_tcp = model.forward_kinematics(pose)};
  (void)reaction_table();

  const std::size_t before = allocations;
  for (const Reaction selected :
       {Reaction::kStop, Reaction::kFloat, Reaction::kRetreat, Reaction::kYield, Reaction::kSlow}) {
    controller.set_cartesian_target(target);
    reaction.begin(selected);
    for (int i = 0; i < 300; ++i) {
      // A push of 8 Nm on joint 2 after 20 ms.
      JointState state{.q = pose, .tau = model.gravity(pose), .theta = pose};
      if (i > 20) state.tau[1] -= 8.0;
      (void)feedback.motor_torques(state, controller.tick(state, kControlPeriod));
      reaction.update(kControlPeriod);
    }
    EXPECT_NE(reaction.state(), ReactionState::kNominal);
  }
  EXPECT_EQ(allocations - before, 0U);
}

}  // namespace
}  // namespace binpick

#endif
