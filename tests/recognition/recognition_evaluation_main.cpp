// Recall, false positives, errors and times of the recognizer on generated scans.

#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "models/errors.h"
#include "recognition/evaluation_diagnosis.h"
#include "recognition/evaluation_picture.h"
#include "recognition/recognition_score.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick::testing {
namespace {

struct Arguments {
  int scenes = 20;
  int first = 0;
  std::vector<std::string> variants = {"kinect"};
  Seed seed = 1;
  int jobs = 1;
  std::string models = "known";
  std::filesystem::path csv;
  std::filesystem::path pictures;
  bool all_pictures = false;
  bool diagnose = false;
};

/// Times of all frames of a variant, ms, by stage in order of appearance.
class StageTimes {
 public:
  void add(const RecognitionResult& result) {
    total_.push_back(1e3 * result.total_seconds);
    for (const StageTiming& timing : result.timings) {
      if (!stages_.contains(timing.stage)) order_.push_back(timing.stage);
      stages_[timing.stage].push_back(1e3 * timing.seconds);
    }
  }
  [[nodiscard]] std::string line() const {
    std::string text =
        fmt::format("{:.1f} ms (p95 {:.1f}):", quantile(total_, 0.5), quantile(total_, 0.95));
    for (const std::string& stage : order_) {
      text += fmt::format(" {} {:.1f}", stage, quantile(stages_.at(stage), 0.5));
    }
    return text;
  }

 private:
  std::vector<double> total_;
  std::vector<std::string> order_;
  std::map<std::string, std::vector<double>> stages_;
};

class Evaluation {
 public:
  explicit Evaluation(const Arguments& arguments)
      : arguments_(arguments),
        generator_(object_set(arguments.models).objects),
        library_(std::make_shared<const ModelLibrary>(object_set(arguments.models).models)),
        recognizer_(library_, options(arguments)) {
    if (!arguments.csv.empty()) {
      csv_.open(arguments.csv);
      if (!csv_) throw IoError(arguments.csv.string() + ": cannot be written");
      csv_ << "variant,scene,what,model,visible_share,in_frame,right,mssd_mm,position_mm,"
              "rotation_deg,visibility,penalty,confidence,ms\n";
    }
    if (!arguments.pictures.empty()) std::filesystem::create_directories(arguments.pictures);
  }

  void run(const std::string& variant) {
    Tally tally;
    StageTimes times;
    for (int scene = arguments_.first; scene < arguments_.first + arguments_.scenes; ++scene) {
      const Seed seed = frame_seed(arguments_.seed, variant, static_cast<std::uint64_t>(scene));
      const SyntheticFrame frame = generator_.frame(draw_parameters(variant, seed), seed);
      const RecognitionResult result = recognize(recognizer_, frame, seed);
      const FrameScore score = score_frame(result.detections, frame, library_->models());
      const int missed_before = tally.visible - tally.found;
      tally.add(score, frame);
      times.add(result);
      if (csv_.is_open()) write_rows(variant, scene, frame, result, score);
      if (arguments_.diagnose) diagnose(variant, scene, frame, result, score);
      const bool failed =
          !score.false_detections.empty() || tally.visible - tally.found > missed_before;
      if (!arguments_.pictures.empty() && (failed || arguments_.all_pictures)) {
        write_picture(arguments_.pictures / fmt::format("{}_{:04}.png", variant, scene), frame,
                      result.detections, score, generator_.known());
      }
    }
    print(variant, tally, times);
  }

 private:
  static RecognizerOptions options(const Arguments& arguments) {
    RecognizerOptions o;
    o.jobs = arguments.jobs;
    o.keep_considered = arguments.diagnose;
    return o;
  }

  void diagnose(const std::string& variant, int scene, const SyntheticFrame& frame,
                const RecognitionResult& result, const FrameScore& score) const {
    for (std::size_t i = 0; i < score.found.size(); ++i) {
      const TrueInstance& instance = frame.scene.instances[i];
      if (score.found[i] || !instance.in_frame || instance.visible_share < 0.15) continue;
      fmt::print("{} {}: {}\n", variant, scene, diagnose_miss(frame, i, result, *library_));
    }
    for (const std::size_t d : score.false_detections) {
      fmt::print("{} {}: {}\n", variant, scene, diagnose_false(frame, d, result, *library_));
    }
  }

  static void print(const std::string& variant, const Tally& tally, const StageTimes& times) {
    const Wilson all = wilson(tally.found, tally.visible);
    const auto share = [](int part, int whole) {
      return whole > 0 ? static_cast<double>(part) / whole : 0.0;
    };
    fmt::print("{:<10} {:>4} {:>5}/{:<5} {:.3f} [{:.3f},{:.3f}] {:>4}/{:<4} {:.2f} {:>6.1f}",
               variant, tally.frames, tally.found, tally.visible, share(tally.found, tally.visible),
               all.low, all.high, tally.hidden_found, tally.hidden,
               share(tally.hidden_found, tally.hidden),
               100.0 * tally.false_positives / tally.frames);
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    fmt::print(" {:>6.2f} {:>6.2f} {:>6.2f}  {}\n", 1e3 * quantile(tally.positions, 0.5),
               1e3 * quantile(tally.positions, 0.95), kDegrees * quantile(tally.rotations, 0.95),
               times.line());
    std::fflush(stdout);
  }

  void write_rows(const std::string& variant, int scene, const SyntheticFrame& frame,
                  const RecognitionResult& result, const FrameScore& score) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    const double ms = 1e3 * result.total_seconds;
    for (std::size_t i = 0; i < score.found.size(); ++i) {
      const TrueInstance& instance = frame.scene.instances[i];
      if (!score.found[i]) {
        csv_ << fmt::format("{},{},miss,{},{:.3f},{:d},0,,,,,,,{:.2f}\n", variant, scene,
                            generator_.known()[instance.model].name, instance.visible_share,
                            instance.in_frame, ms);
      }
    }
    const auto row = [&](std::size_t d, const FrameScore::Match* match) {
      const Detection& detection = result.detections[d];
      std::string truth = ",,0,,,";
      if (match != nullptr) {
        const TrueInstance& instance = frame.scene.instances[match->instance];
        truth = fmt::format("{:.3f},{:d},1,{:.2f},{:.2f},{:.2f}", instance.visible_share,
                            instance.in_frame, 1e3 * match->mssd, 1e3 * match->error.translation,
                            kDegrees * match->error.rotation);
      }
      csv_ << fmt::format("{},{},{},{},{},{:.3f},{:.3f},{:.4f},{:.2f}\n", variant, scene,
                          match != nullptr ? "hit" : "false", detection.model, truth,
                          detection.visibility, detection.penalty, detection.confidence, ms);
    };
    for (const FrameScore::Match& match : score.matches) row(match.detection, &match);
    for (const std::size_t d : score.false_detections) row(d, nullptr);
  }

  const Arguments& arguments_;
  SceneGenerator generator_;
  std::shared_ptr<const ModelLibrary> library_;
  Recognizer recognizer_;
  std::ofstream csv_;
};

int evaluate(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Recognition on generated scans: recall, false positives, errors, times");
  std::string names;
  for (const std::string& name : variant_names()) names += " " + name;
  app.add_option("--scenes", arguments.scenes, "scenes per variant")->check(CLI::PositiveNumber);
  app.add_option("--first", arguments.first, "number of the first scene")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--variant", arguments.variants, "all or some of:" + names)->delimiter(',');
  app.add_option("--seed", arguments.seed,
                 "master seed; 1-999 for tuning, results are reported from 1000 on");
  app.add_option("--jobs", arguments.jobs, "threads of the recognizer")->check(CLI::PositiveNumber);
  app.add_option("--models", arguments.models, "known, toys, open or scans");
  app.add_option("--csv", arguments.csv, "a row per miss and per detection");
  app.add_option("--pictures", arguments.pictures, "folder for PNGs of scenes with a failure");
  app.add_flag("--diagnose", arguments.diagnose, "print the cause of every failure");
  app.add_flag("--all-pictures", arguments.all_pictures, "of all scenes");
  CLI11_PARSE(app, argc, argv);
  if (arguments.variants == std::vector<std::string>{"all"}) arguments.variants = variant_names();
  for (const std::string& variant : arguments.variants) (void)draw_parameters(variant, 0);
  Evaluation evaluation(arguments);
  fmt::print(
      "models {}, master seed {}\n{:<10} {:>4} {:>11} {:>21} {:>14} {:>6} {:>6} {:>6} {:>6}  "
      "{}\n",
      arguments.models, arguments.seed, "variant", "n", "found >=30%", "recall 95 % interval",
      "found 15-30%", "f.p./c", "med mm", "p95 mm", "p95 deg", "median times");
  for (const std::string& variant : arguments.variants) evaluation.run(variant);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("peak memory, scene generator included: {} MB\n", usage.ru_maxrss / 1024);
  return 0;
}

}  // namespace
}  // namespace binpick::testing

int main(int argc, char** argv) {
  try {
    return binpick::testing::evaluate(argc, argv);
  } catch (const binpick::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  } catch (const binpick::IoError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
}
