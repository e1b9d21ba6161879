#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>

#include "recognition/recognition_score.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

using testing::Tally;
using testing::Wilson;

constexpr Seed kMasterSeed = 2000;

/// The frames of a variant, searched with default settings.
Tally search(const std::string& models, const std::string& variant, int frames) {
  const testing::ObjectSet set = testing::object_set(models);
  const testing::SceneGenerator generator(set.objects);
  const auto library = std::make_shared<const ModelLibrary>(set.models);
  const Recognizer recognizer(library, RecognizerOptions{});
  Tally tally;
  for (int i = 0; i < frames; ++i) {
    const Seed seed = testing::frame_seed(kMasterSeed, variant, static_cast<Seed>(i));
    const testing::SyntheticFrame frame =
        generator.frame(testing::draw_parameters(variant, seed), seed);
    const RecognitionResult result = testing::recognize(recognizer, frame, seed);
    tally.add(testing::score_frame(result.detections, frame, library->models()), frame);
  }
  return tally;
}

/// The rate per frame that is so high that as few events as seen would come in 5 % of such runs:
/// exp(-m) sum m^k / k! = 0.05 with m = rate x frames.
double highest_rate(int events, int frames) {
  double low = 0.0;
  double high = 10.0 + 3.0 * events;
  for (int i = 0; i < 60; ++i) {
    const double mean = 0.5 * (low + high);
    double term = std::exp(-mean);
    double at_most = term;
    for (int k = 1; k <= events; ++k) at_most += term *= mean / k;
    (at_most > 0.05 ? low : high) = mean;
  }
  return high / frames;
}

/// What a variant must show: bounds of 95 % intervals, not bare percentages. They are floors under
/// what was reached, not the aims; a few dozen objects cannot show more.
struct Gate {
  /// By name in the output of a failed test.
  friend void PrintTo(const Gate& gate, std::ostream* out) { *out << gate.name; }

  const char* name;
  const char* models;
  const char* variant;
  int frames;
  double least_recall;          ///< lower bound of Wilson's interval, objects that show 30 %
  double most_false_positives;  ///< upper bound per frame
  double most_median_error;     ///< m
  double most_rotation;         ///< 95th percentile, rad
};

class Recall : public ::testing::TestWithParam<Gate> {};

TEST_P(Recall, HoldsItsBounds) {
  const Gate& gate = GetParam();
  const Tally tally = search(gate.models, gate.variant, gate.frames);
  const Wilson recall = testing::wilson(tally.found, tally.visible);
  const double false_rate = highest_rate(tally.false_positives, tally.frames);
  const double median = testing::quantile(tally.positions, 0.5);
  const double rotation = testing::quantile(tally.rotations, 0.95);
  std::printf(
      "%s %s, master seed %llu: recall %d of %d, 95 %% interval [%.3f, %.3f]; %d false in %d "
      "frames, "
      "at most %.2f a frame; median error %.2f mm, 95th percentile of rotation %.1f deg\n",
      gate.models, gate.variant, static_cast<unsigned long long>(kMasterSeed), tally.found,
      tally.visible, recall.low, recall.high, tally.false_positives, tally.frames, false_rate,
      1e3 * median, rotation * 180.0 / std::numbers::pi);
  EXPECT_GE(recall.low, gate.least_recall);
  EXPECT_LE(false_rate, gate.most_false_positives);
  EXPECT_LE(median, gate.most_median_error);
  EXPECT_LE(rotation, gate.most_rotation);
}

INSTANTIATE_TEST_SUITE_P(
    GeneratedScans, Recall,
    ::testing::Values(Gate{"KinectPiles", "known", "kinect", 16, 0.92, 0.4, 0.0025, 0.090},
                      Gate{"DilatedPiles", "known", "dilated", 24, 0.88, 0.5, 0.0025, 0.085},
                      Gate{"LaserPiles", "known", "laser", 12, 0.88, 0.5, 0.0015, 0.055},
                      Gate{"UnknownObjects", "known", "unknown", 12, 0.78, 1.0, 0.0025, 0.080},
                      Gate{"Toys", "toys", "kinect", 10, 0.85, 0.4, 0.0025, 0.050},
                      Gate{"ScannedToys", "scans", "laser", 10, 0.88, 0.4, 0.0015, 0.040},
                      Gate{"Harsh", "known", "harsh", 64, 0.85, 0.5, 0.0025, 0.110}),
    [](const auto& gate) { return std::string(gate.param.name); });

}  // namespace
}  // namespace binpick
