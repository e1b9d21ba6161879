#include <benchmark/benchmark.h>

#include "sim/depth_camera.h"
#include "sim/pile.h"
#include "sim/world_support.h"

namespace binpick {
namespace {

using testing::cell;
using testing::make_world;

void step_standing_bottle(benchmark::State& state) {
  World world = make_world("blind_bottle");
  for (auto _ : state) world.step();
}
BENCHMARK(step_standing_bottle)->Unit(benchmark::kMicrosecond);

/// The arm let go, balanced, with elastic joints or rigid ones.
World free_arm(const char* scene, bool elastic) {
  const auto shared = cell(scene);
  std::optional<DriveDescription> drives;
  if (elastic) drives = load_lwr_drives();
  World world(shared, centre_physics(shared->parts.objects), drives);
  if (shared->parts.scene.arrangement != "standing") drop_pile(world, 1);
  world.hold_arm(false);
  world.set_arm_torques(world.balancing_torques());
  return world;
}

/// 1 ms of nothing but the arm, of one bottle on the table, or of a settled pile of seven.
void step_free_arm(benchmark::State& state, const char* scene, bool elastic, bool empty) {
  World world = free_arm(scene, elastic);
  for (int i = 0; empty && i < world.object_count(); ++i) world.park_object(i);
  for (auto _ : state) world.step();
}
BENCHMARK_CAPTURE(step_free_arm, alone_rigid, "blind_bottle", false, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(step_free_arm, alone_elastic, "blind_bottle", true, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(step_free_arm, bottle_rigid, "blind_bottle", false, false)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(step_free_arm, bottle_elastic, "blind_bottle", true, false)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(step_free_arm, pile_rigid, "pile", false, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(step_free_arm, pile_elastic, "pile", true, false)->Unit(benchmark::kMicrosecond);

void step_settled_pile_of_seven(benchmark::State& state) {
  World world = make_world("pile");
  drop_pile(world, 1);
  const WorldState settled = world.save_state();
  for (auto _ : state) world.step();
}
BENCHMARK(step_settled_pile_of_seven)->Unit(benchmark::kMicrosecond);

void physics_alone_settled_pile(benchmark::State& state) {
  World world = make_world("pile");
  drop_pile(world, 1);
  for (auto _ : state) mj_step(&world.model(), &world.mutable_data());
}
BENCHMARK(physics_alone_settled_pile)->Unit(benchmark::kMicrosecond);

void ideal_depth_frame(benchmark::State& state) {
  World world = make_world("pile");
  drop_pile(world, 1);
  DepthCamera camera(cell("pile"));
  for (auto _ : state) benchmark::DoNotOptimize(camera.ideal(world).depth.data());
}
BENCHMARK(ideal_depth_frame)->Unit(benchmark::kMillisecond);

void noisy_depth_frame(benchmark::State& state) {
  World world = make_world("pile");
  drop_pile(world, 1);
  DepthCamera camera(cell("pile"));
  Seed frame = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.capture(world, {}, frame++).depth.data());
  }
}
BENCHMARK(noisy_depth_frame)->Unit(benchmark::kMillisecond);

void make_world_of_a_trial(benchmark::State& state) {
  const auto shared = cell("blind_bottle");
  const PhysicsDraw draw = centre_physics(shared->parts.objects);
  for (auto _ : state) benchmark::DoNotOptimize(World(shared, draw).time());
}
BENCHMARK(make_world_of_a_trial)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace binpick
