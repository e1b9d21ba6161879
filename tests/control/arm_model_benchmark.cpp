#include <benchmark/benchmark.h>

#include <vector>

#include "control/arm_model.h"
#include "control/inverse_kinematics.h"
#include "control/test_arm.h"

namespace binpick {
namespace {

constexpr std::size_t kPostures = 256;

std::vector<JointVector> postures(const ArmModel& arm) {
  Random random(1);
  std::vector<JointVector> result;
  for (std::size_t i = 0; i < kPostures; ++i) {
    result.push_back(testing::random_posture(random, arm.limits()));
  }
  return result;
}

void evaluate_arm(benchmark::State& state) {
  const ArmModel arm = testing::make_arm();
  const std::vector<JointVector> q = postures(arm);
  std::size_t i = 0;
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(arm.evaluate(q[i % kPostures], q[(i + 1) % kPostures]));
    ++i;
  }
}
BENCHMARK(evaluate_arm);

void forward_kinematics(benchmark::State& state) {
  const ArmModel arm = testing::make_arm();
  const std::vector<JointVector> q = postures(arm);
  std::size_t i = 0;
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(arm.forward_kinematics(q[i++ % kPostures]));
  }
}
BENCHMARK(forward_kinematics);

/// All branches of a pose at one swivel angle.
void branches_at_one_swivel(benchmark::State& state) {
  const ArmModel arm = testing::make_arm();
  const InverseKinematics kinematics(arm);
  std::vector<Eigen::Isometry3d> poses;
  for (const JointVector& q : postures(arm)) poses.push_back(arm.forward_kinematics(q));
  std::size_t i = 0;
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(kinematics.branches(poses[i % kPostures], 0.3));
    ++i;
  }
}
BENCHMARK(branches_at_one_swivel)->Unit(benchmark::kMicrosecond);

/// The best posture over 72 swivel angles.
void solve_inverse_kinematics(benchmark::State& state) {
  const ArmModel arm = testing::make_arm();
  const InverseKinematics kinematics(arm);
  const std::vector<JointVector> q = postures(arm);
  std::size_t i = 0;
  for ([[maybe_unused]] const auto step : state) {
    const Eigen::Isometry3d T_world_tcp = arm.forward_kinematics(q[i % kPostures]);
    benchmark::DoNotOptimize(kinematics.solve(T_world_tcp, q[(i + 1) % kPostures]));
    ++i;
  }
}
BENCHMARK(solve_inverse_kinematics)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace binpick
