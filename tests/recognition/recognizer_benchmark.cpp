#include <benchmark/benchmark.h>

#include "recognition/acceptance_function.h"
#include "recognition/hypothesis_evidence.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

using testing::SceneKind;

const testing::SyntheticScene& pile() {
  static const testing::SyntheticScene scene =
      testing::SceneGenerator(testing::known_objects()).make(SceneKind::kPile, 4);
  return scene;
}

const RangeImage& frame() {
  static const RangeImage image = testing::add_kinect_noise(pile().clean, {}, 4);
  return image;
}

std::shared_ptr<const ModelLibrary> library() {
  static const auto shared = std::make_shared<const ModelLibrary>(testing::known_objects());
  return shared;
}

/// A 640 x 480 frame of a pile of seven, three models, refinement included; stages as counters, ms.
void recognize_frame(benchmark::State& state) {
  RecognizerOptions options;
  options.jobs = static_cast<int>(state.range(0));
  const Recognizer recognizer(library(), options);
  const RangeImage& image = frame();
  Seed seed = 0;
  for (auto _ : state) {
    const RecognitionResult result = recognizer.recognize(image, seed++);
    for (const StageTiming& timing : result.timings) {
      state.counters[timing.stage] += 1e3 * timing.seconds;
    }
  }
  for (auto& [name, counter] : state.counters) counter.flags = benchmark::Counter::kAvgIterations;
}
BENCHMARK(recognize_frame)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// A laser scan of some 290 000 points of a pile of free-form toys, as an unorganised cloud; the
/// projection is part of it.
void recognize_laser_scan(benchmark::State& state) {
  static const testing::SceneGenerator generator(testing::toy_objects());
  static const testing::SyntheticFrame scan = [] {
    testing::SceneParameters parameters = testing::draw_parameters("laser", 4);
    parameters.known = 4;
    return generator.frame(parameters, 4);
  }();
  static const auto toys = std::make_shared<const ModelLibrary>(testing::toy_objects());
  RecognizerOptions options;
  options.jobs = static_cast<int>(state.range(0));
  const Recognizer recognizer(toys, options);
  Seed seed = 0;
  std::size_t found = 0;
  for (auto _ : state) {
    const RecognitionResult result =
        recognizer.recognize(scan.cloud, scan.p_scene_viewpoint, seed++);
    found += result.detections.size();
    for (const StageTiming& timing : result.timings) {
      state.counters[timing.stage] += 1e3 * timing.seconds;
    }
  }
  state.counters["found"] = static_cast<double>(found);
  for (auto& [name, counter] : state.counters) counter.flags = benchmark::Counter::kAvgIterations;
}
BENCHMARK(recognize_laser_scan)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The repository's three objects, or its free-form toys, from meshes in memory.
void prepare_library(benchmark::State& state) {
  const std::vector<ModelSource> sources =
      state.range(0) == 0 ? testing::known_objects() : testing::toy_objects();
  const auto jobs = static_cast<int>(state.range(1));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        ModelLibrary(sources, RecognizerSetting::kDefault, jobs).pairs().size());
  }
}
BENCHMARK(prepare_library)
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->ArgNames({"toys", "jobs"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void observe_scene(benchmark::State& state) {
  const auto jobs = static_cast<int>(state.range(0));
  for (auto _ : state) {
    const ObservedScene observed(frame(), {library()->leaf_size(), 0.054}, jobs, 1);
    benchmark::DoNotOptimize(observed.object_leaves().size());
  }
}
BENCHMARK(observe_scene)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void test_hypothesis(benchmark::State& state) {
  const ObservedScene observed(frame(), {library()->leaf_size(), 0.054}, 1, 1);
  const RecognitionModel& model = library()->models()[pile().instances[0].model];
  const Eigen::Isometry3f truth = pile().instances[0].T_camera_model.cast<float>();
  std::vector<Eigen::Isometry3f> poses;
  Random random(5);
  for (int i = 0; i < 1024; ++i) {
    Eigen::Isometry3f T = truth;
    T.linear() = random.rotation().cast<float>().toRotationMatrix();
    poses.push_back(T);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        test_in_cascade(observed, model, poses[i++ % poses.size()], {0.006f, 0.18f, 0.2f}));
  }
}
BENCHMARK(test_hypothesis);

void verify_hypothesis(benchmark::State& state) {
  const ObservedScene observed(frame(), {library()->leaf_size(), 0.054}, 1, 1);
  const testing::TrueInstance& instance =
      pile().instances[static_cast<std::size_t>(state.range(0))];
  const RecognitionModel& model = library()->models()[instance.model];
  const Eigen::Isometry3f truth = instance.T_camera_model.cast<float>();
  const SensorEstimate sensor = estimate_sensor(observed);
  EvidenceGatherer gatherer(observed, sensor);
  for (auto _ : state) benchmark::DoNotOptimize(gatherer.gather(model, truth).matched);
}
BENCHMARK(verify_hypothesis)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace binpick
