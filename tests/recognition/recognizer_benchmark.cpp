#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Medians over all frames that were recognized, ms: the whole, and each stage.
class FrameTimes {
 public:
  void add(const RecognitionResult& result) {
    times_["median"].push_back(1e3 * result.total_seconds);
    for (const StageTiming& timing : result.timings) {
      times_[timing.stage].push_back(1e3 * timing.seconds);
    }
    found_ += result.detections.size();
  }
  void report(benchmark::State& state) const {
    for (const auto& [name, values] : times_) state.counters[name] = median(values);
    state.counters["found"] = static_cast<double>(found_) / static_cast<double>(state.iterations());
  }

 private:
  std::map<std::string, std::vector<double>> times_;
  std::size_t found_ = 0;
};

/// Ten scans of piles: of the three known objects, or of four free-form toys.
struct Scans {
  Scans(std::vector<ModelSource> sources, const std::string& variant, int objects)
      : library(std::make_shared<const ModelLibrary>(sources)) {
    const testing::SceneGenerator generator(std::move(sources));
    for (Seed seed = 1; seed <= 10; ++seed) {
      testing::SceneParameters parameters = testing::draw_parameters(variant, seed);
      if (objects > 0) parameters.known = objects;
      frames.push_back(generator.frame(parameters, seed));
    }
  }

  std::shared_ptr<const ModelLibrary> library;
  std::vector<testing::SyntheticFrame> frames;
};

void recognize(benchmark::State& state, const Scans& scans) {
  RecognizerOptions options;
  options.jobs = static_cast<int>(state.range(0));
  const Recognizer recognizer(scans.library, options);
  FrameTimes times;
  Seed seed = 0;
  for (auto _ : state) {
    const testing::SyntheticFrame& scan = scans.frames[seed % scans.frames.size()];
    times.add(scan.cloud.points.empty()
                  ? recognizer.recognize(scan.image, seed)
                  : recognizer.recognize(scan.cloud, scan.p_scene_viewpoint, seed));
    ++seed;
  }
  times.report(state);
}

/// Kinect frames of 640 x 480 with five or six visible objects, refinement included.
void recognize_known_kinect(benchmark::State& state) {
  static const Scans scans(testing::known_objects(), "kinect", 0);
  recognize(state, scans);
}
BENCHMARK(recognize_known_kinect)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void recognize_toys_kinect(benchmark::State& state) {
  static const Scans scans(testing::toy_objects(), "kinect", 0);
  recognize(state, scans);
}
BENCHMARK(recognize_toys_kinect)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Laser scans of some 290 000 points of four free-form toys, as unorganised clouds; their
/// projection is part of it.
void recognize_toys_laser(benchmark::State& state) {
  static const Scans scans(testing::toy_objects(), "laser", 4);
  recognize(state, scans);
  std::vector<double> points;
  for (const testing::SyntheticFrame& scan : scans.frames) {
    points.push_back(static_cast<double>(scan.cloud.points.size()));
  }
  state.counters["points"] = median(points);
}
BENCHMARK(recognize_toys_laser)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Ten million points that fill a cube of a metre: nothing is known there, and no pixel is like its
/// neighbours.
void recognize_ten_million_points(benchmark::State& state) {
  static const PointCloud cloud = [] {
    PointCloud points;
    Random random(1);
    for (int i = 0; i < 10'000'000; ++i) {
      const auto along = [&] { return static_cast<float>(random.uniform(-0.5, 0.5)); };
      points.points.emplace_back(along(), along(), 1.5f + along());
    }
    return points;
  }();
  RecognizerOptions options;
  options.jobs = static_cast<int>(state.range(0));
  const Recognizer recognizer(library(), options);
  FrameTimes times;
  Seed seed = 0;
  for (auto _ : state) {
    times.add(recognizer.recognize(cloud, Eigen::Vector3d::Zero(), seed++));
  }
  times.report(state);
}
BENCHMARK(recognize_ten_million_points)
    ->Arg(1)
    ->Arg(2)
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

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
  const SensorEstimate sensor = observed.sensor();
  EvidenceGatherer gatherer(observed, sensor);
  for (auto _ : state) benchmark::DoNotOptimize(gatherer.gather(model, truth).matched);
}
BENCHMARK(verify_hypothesis)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace binpick
