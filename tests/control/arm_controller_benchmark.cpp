#include <benchmark/benchmark.h>

#include <array>
#include <cmath>

#include "control/arm_controller.h"
#include "control/arm_plant.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

/// States along a fast motion (joints near their speed limits), prepared in advance.
std::array<JointState, 1000> moving_states(const ArmModel& model) {
  std::array<JointState, 1000> states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double phase = 2.0 * M_PI * static_cast<double>(i) / 1000.0;
    JointState& state = states[i];
    for (int j = 0; j < kArmJoints; ++j) {
      state.q[j] = test_poses()[1][j] + 0.25 * std::sin(phase + j);
      state.qd[j] = 0.25 * 2.0 * M_PI * std::cos(phase + j);
    }
    state.tau = model.gravity(state.q);
    state.theta = state.q;
  }
  return states;
}

/// Time per control tick, s: observer, wrench, contact classification, impedance, null space,
/// limits. Report the median of repetitions.
void tick(benchmark::State& bench, ControlMode mode) {
  const ArmModel model = testing::make_arm();
  const std::array<JointState, 1000> states = moving_states(model);
  ArmController controller(model);
  if (mode == ControlMode::kCartesian) {
    controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(test_poses()[1]),
                                     .twist = (Vector6() << 0.1, 0.2, 0.3, 0, 0, 0.1).finished()});
  } else {
    controller.set_joint_target({.q = test_poses()[1]});
  }
  std::size_t i = 0;
  for (auto _ : bench) {
    benchmark::DoNotOptimize(controller.tick(states[i], kControlPeriod));
    i = i + 1 < states.size() ? i + 1 : 0;
  }
}
BENCHMARK_CAPTURE(tick, cartesian, ControlMode::kCartesian);
BENCHMARK_CAPTURE(tick, joint, ControlMode::kJoint);

void evaluate_dynamics(benchmark::State& bench) {
  const ArmModel model = testing::make_arm();
  const std::array<JointState, 1000> states = moving_states(model);
  std::size_t i = 0;
  for (auto _ : bench) {
    benchmark::DoNotOptimize(model.evaluate(states[i].q, states[i].qd));
    i = i + 1 < states.size() ? i + 1 : 0;
  }
}
BENCHMARK(evaluate_dynamics);

}  // namespace
}  // namespace binpick
