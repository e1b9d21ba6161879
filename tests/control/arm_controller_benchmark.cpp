#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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

/// The controller at work along a Cartesian line, elastic joints on demand.
ArmController working_controller(const ArmModel& model, bool elastic) {
  ArmControllerOptions options;
  if (elastic) options.joints = ElasticJoints::of(load_lwr_drives());
  ArmController controller(model, options);
  controller.set_cartesian_target({.T_world_tcp = model.forward_kinematics(test_poses()[1]),
                                   .twist = (Vector6() << 0.1, 0.2, 0.3, 0, 0, 0.1).finished()});
  return controller;
}

double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Every tick timed for itself, in thread CPU time, less what reading the clock takes: median and
/// 99.9th percentile. Interrupts count as the thread's time; `worst_tick_us` is without them: of
/// the 1000 ticks of a round the dearest, each by its median over the rounds.
void tick_percentiles(benchmark::State& bench) {
  const ArmModel model = testing::make_arm();
  const std::array<JointState, 1000> states = moving_states(model);
  ArmController controller = working_controller(model, false);
  std::vector<double> times;
  std::vector<double> clock;
  for (auto _ : bench) {
    for (const JointState& state : states) {
      const double start = thread_time();
      benchmark::DoNotOptimize(controller.tick(state, kControlPeriod));
      const double end = thread_time();
      times.push_back(end - start);
      clock.push_back(thread_time() - end);
    }
  }
  const auto percentile = [](std::vector<double>& samples, double share) {
    const auto nth = static_cast<std::ptrdiff_t>(share * static_cast<double>(samples.size() - 1));
    std::nth_element(samples.begin(), samples.begin() + nth, samples.end());
    return samples[static_cast<std::size_t>(nth)];
  };
  const double overhead = percentile(clock, 0.5);
  double worst = 0.0;
  for (std::size_t tick = 0; tick < states.size(); ++tick) {
    std::vector<double> rounds;
    for (std::size_t i = tick; i < times.size(); i += states.size()) rounds.push_back(times[i]);
    worst = std::max(worst, percentile(rounds, 0.5));
  }
  bench.counters["median_us"] = 1e6 * (percentile(times, 0.5) - overhead);
  bench.counters["worst_tick_us"] = 1e6 * (worst - overhead);
  bench.counters["p99.9_us"] = 1e6 * (percentile(times, 0.999) - overhead);
}
BENCHMARK(tick_percentiles)->Unit(benchmark::kMillisecond)->Iterations(200);

/// With elastic joints: also the fixed point for qb, two steps, each with its own dynamics.
void tick_elastic(benchmark::State& bench) {
  const ArmModel model = testing::make_arm();
  const std::array<JointState, 1000> states = moving_states(model);
  ArmController controller = working_controller(model, true);
  std::size_t i = 0;
  for (auto _ : bench) {
    benchmark::DoNotOptimize(controller.tick(states[i], kControlPeriod));
    i = i + 1 < states.size() ? i + 1 : 0;
  }
}
BENCHMARK(tick_elastic);

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
