#include <benchmark/benchmark.h>

#include "models/cloud_file.h"
#include "models/mesh_geometry.h"
#include "models/object_model.h"
#include "models/robot_description.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

/// What every run of the program pays: three objects and the arm.
void BM_LoadCell(benchmark::State& state) {
  for (auto _ : state) {
    for (const char* name : {"bottle", "amicelli", "rusk"}) {
      benchmark::DoNotOptimize(load_known_object(name));
    }
    benchmark::DoNotOptimize(load_lwr());
  }
}
BENCHMARK(BM_LoadCell)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_SampleSurface(benchmark::State& state) {
  const ObjectModel bottle = load_known_object("bottle");
  for (auto _ : state) benchmark::DoNotOptimize(sample_surface(bottle.mesh, 10000, 1));
}
BENCHMARK(BM_SampleSurface)->Unit(benchmark::kMillisecond);

void BM_ReadPly(benchmark::State& state) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "cloud.ply";
  write_ply(file, sample_surface(load_known_object("bottle").mesh, 300000, 1));
  for (auto _ : state) benchmark::DoNotOptimize(read_cloud(file));
}
BENCHMARK(BM_ReadPly)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace binpick
