// Writes recognition/acceptance_weights.cpp: the log-likelihood ratio by which hypotheses are
// accepted, fitted on generated scans.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "models/errors.h"
#include "recognition/logistic_fit.h"
#include "recognition/parallel_for.h"
#include "recognition/pose_metrics.h"
#include "recognition/recognition_score.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"
#include "recognition/visible_surface_discrepancy.h"

namespace binpick::testing {
namespace {

constexpr double kRidge = 1.0;
// MSSD, diameters: what lies between this and kRightPose teaches features nothing.
constexpr double kWrongPose = 0.2;
// Visible surface discrepancy, with 0.05 diameters of tolerance, below which a view does not tell
// two poses apart (an upright and an upturned cup): no labels either.
constexpr double kLooksAlike = 0.2;
constexpr double kFarthestAlike = 0.3;    // diameters between the centres of such poses
constexpr double kMostClaimed = 0.35;     // the selection does not ask about more
constexpr double kCandidateWeight = 0.1;  // beside a detection's 1
// Wrong detections per frame at the threshold. Several times the demand on piles of known objects,
// for three quarters of the calibration's scans are harsh or full of foreign objects, and nearly
// all wrong detections come from there. Of tuning piles with foreign objects it makes three in 100
// have one.
constexpr double kMostFalse = 0.05;

struct Arguments {
  int scenes = 300;
  int passes = 2;
  int jobs = 2;
  bool from_calibrated = false;
  std::filesystem::path out;
  std::filesystem::path rows;
};

/// Half the scans as harsh as the generator can, a quarter from all named variants in turn, a
/// quarter with what a model can be mistaken for; four sets of models.
struct Recipe {
  std::size_t set = 0;
  std::string variant;
};
Recipe recipe_of(int index) {
  constexpr std::array<std::size_t, 10> kSets = {0, 1, 3, 2, 0, 0, 1, 0, 2, 3};
  constexpr std::array<const char*, 3> kMistakable = {"unknown", "nothing", "copies"};
  const auto i = static_cast<std::size_t>(index);
  const std::vector<std::string>& names = variant_names();
  const std::size_t set = kSets[i % kSets.size()];
  if (i % 2 == 0) return {set, "harsh"};
  if (i % 4 == 1) return {set, names[(i / 4) % names.size()]};
  return {set, kMistakable[(i / 4) % kMistakable.size()]};
}

/// What one frame contributes.
struct FrameRows {
  std::vector<LabelledFeatures> candidates;  ///< all that were compared with the scene
  std::vector<LabelledFeatures> selected;    ///< those that a low threshold lets through
  /// Per instance inside the image: what it shows, and whether any candidate had its pose.
  struct Instance {
    double visible_share = 0.0;
    bool was_candidate = false;
    bool is_selected = false;
  };
  std::vector<Instance> instances;
  Recipe recipe;
};

class Calibration {
 public:
  explicit Calibration(const Arguments& arguments) : arguments_(arguments) {
    for (const char* name : {"known", "toys", "open", "scans"}) {
      const ObjectSet set = object_set(name);
      generators_.emplace_back(set.objects);
      libraries_.push_back(std::make_shared<const ModelLibrary>(set.models));
    }
  }

  /// Searches `arguments.scenes` scans with `acceptance` at a threshold of five per cent.
  [[nodiscard]] std::vector<FrameRows> collect(AcceptanceModel acceptance, Seed master) const {
    acceptance.least_probability = 0.05;
    std::vector<FrameRows> frames(static_cast<std::size_t>(arguments_.scenes));
    parallel_for(arguments_.scenes, arguments_.jobs, [&](int i) {
      frames[static_cast<std::size_t>(i)] = rows_of(i, acceptance, master);
      if (i % 25 == 24) fmt::print(stderr, "scan {} of {}\n", i + 1, arguments_.scenes);
    });
    return frames;
  }

 private:
  [[nodiscard]] FrameRows rows_of(int index, const AcceptanceModel& acceptance, Seed master) const {
    const Recipe recipe = recipe_of(index);
    const Seed seed = frame_seed(master, recipe.variant, static_cast<std::uint64_t>(index));
    const SyntheticFrame frame =
        generators_[recipe.set].frame(draw_parameters(recipe.variant, seed), seed);
    RecognizerOptions options;
    options.acceptance = &acceptance;
    options.keep_considered = true;
    const RecognitionResult result =
        recognize(Recognizer(libraries_[recipe.set], options), frame, seed);
    FrameRows rows;
    rows.recipe = recipe;
    const std::size_t instances = frame.scene.instances.size();
    std::vector<FrameRows::Instance> seen(instances);
    for (const ConsideredHypothesis& considered : result.considered) {
      const Nearest nearest = nearest_to(considered, frame, libraries_[recipe.set]->models());
      const bool is_right = nearest.distance < kRightPose;
      if (is_right) {
        seen[nearest.instance].was_candidate = true;
        seen[nearest.instance].is_selected |= considered.is_selected;
      }
      const bool is_slid = !is_right && nearest.distance < kWrongPose;
      if (!is_right && !is_slid &&
          looks_alike(considered, frame, libraries_[recipe.set]->models())) {
        continue;
      }
      const auto claimed = considered.features[static_cast<std::size_t>(Feature::kClaimed)];
      if (claimed * claimed > kMostClaimed) continue;
      const LabelledFeatures row{.features = considered.features,
                                 .margin = considered.margin,
                                 .displacement = considered.displacement,
                                 .is_right = is_right,
                                 .is_beside = is_slid,
                                 .scan = index};
      if (!is_slid) {
        rows.candidates.push_back(row);
        rows.candidates.back().weight = kCandidateWeight;
      }
      if (!considered.is_selected) continue;
      rows.selected.push_back(row);
      rows.selected.back().weight = is_slid ? 0.0 : 1.0;
    }
    for (std::size_t i = 0; i < instances; ++i) {
      if (!frame.scene.instances[i].in_frame) continue;
      seen[i].visible_share = frame.scene.instances[i].visible_share;
      rows.instances.push_back(seen[i]);
    }
    return rows;
  }

  struct Nearest {
    std::size_t instance = 0;
    double distance = std::numeric_limits<double>::infinity();  // MSSD, diameters
    double visible_share = 0.0;
  };
  /// The instance of the hypothesis' model whose pose is most like its own.
  static Nearest nearest_to(const ConsideredHypothesis& considered, const SyntheticFrame& frame,
                            const std::vector<RecognitionModel>& models) {
    const std::vector<TrueInstance>& instances = frame.scene.instances;
    Nearest nearest;
    for (std::size_t i = 0; i < instances.size(); ++i) {
      const RecognitionModel& model = models[instances[i].model];
      if (model.name != considered.model) continue;
      const double distance =
          mssd(considered.T_scene_model, frame.T_scene_camera * instances[i].T_camera_model,
               model.hull, model.symmetries) /
          static_cast<double>(model.diameter);
      if (distance < nearest.distance) nearest = {i, distance, instances[i].visible_share};
    }
    return nearest;
  }

  /// Whether the hypothesis shows what some true instance of its model shows.
  static bool looks_alike(const ConsideredHypothesis& considered, const SyntheticFrame& frame,
                          const std::vector<RecognitionModel>& models) {
    const CameraIntrinsics& camera = frame.image.intrinsics;
    const Projection projection = projection_of(camera);
    return std::any_of(frame.scene.instances.begin(), frame.scene.instances.end(),
                       [&](const TrueInstance& instance) {
                         const RecognitionModel& model = models[instance.model];
                         if (model.name != considered.model) return false;
                         const auto diameter = static_cast<double>(model.diameter);
                         const Eigen::Vector3d centre = model.centre.cast<double>();
                         const Eigen::Isometry3d T_estimated =
                             frame.T_scene_camera.inverse() * considered.T_scene_model;
                         // What lies elsewhere does not: comparing images takes long.
                         if ((T_estimated * centre - instance.T_camera_model * centre).norm() >
                             kFarthestAlike * diameter) {
                           return false;
                         }
                         return visible_surface_discrepancy(
                                    T_estimated, instance.T_camera_model, model.render_mesh,
                                    frame.image.depth, projection,
                                    {0.1 * diameter, 0.05 * diameter}) < kLooksAlike;
                       });
  }

  const Arguments& arguments_;
  std::vector<SceneGenerator> generators_;
  std::vector<std::shared_ptr<const ModelLibrary>> libraries_;
};

/// Accepts nothing that looks odd in any way: for the first pass.
AcceptanceModel starting_model() {
  AcceptanceModel model;
  model.bias = 2.0;
  for (const Feature feature :
       {Feature::kBadNormal, Feature::kSeenThrough, Feature::kSeenThroughRim,
        Feature::kNearOccluded, Feature::kClaimed, Feature::kContinued}) {
    model.terms[static_cast<std::size_t>(feature)].slope = -6.0;
  }
  return model;
}

void append(std::vector<LabelledFeatures>& rows, const std::vector<LabelledFeatures>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
}

/// What models that were fitted to the rows of all scans but every fifth say about the `judged`
/// rows of those, in their order. Confidence and threshold follow from these: no model is modest
/// about its own rows.
std::vector<JudgedRow> cross_validate(const std::vector<LabelledFeatures>& rows,
                                      const std::vector<LabelledFeatures>& judged) {
  constexpr int kFolds = 5;
  std::vector<JudgedRow> result(judged.size());
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<LabelledFeatures> others;
    for (const LabelledFeatures& row : rows) {
      if (row.scan % kFolds != fold) others.push_back(row);
    }
    const AcceptanceModel model = fit_acceptance(others, kRidge);
    for (std::size_t i = 0; i < judged.size(); ++i) {
      const LabelledFeatures& row = judged[i];
      if (row.scan % kFolds != fold) continue;
      result[i] = {model.log_odds(row.features), row.margin, row.is_right || row.is_beside};
    }
  }
  return result;
}

/// A detection as the threshold sees it.
struct JudgedDetection {
  double probability = 0.0;
  bool is_right = false;
};

/// `log_odds` are those of the rows.
std::vector<JudgedDetection> judge(const AcceptanceModel& model,
                                   const std::vector<LabelledFeatures>& rows,
                                   const std::vector<double>& log_odds) {
  std::vector<JudgedDetection> judged;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const LabelledFeatures& row = rows[i];
    judged.push_back(
        {model.detection_probability(log_odds[i], row.margin, row.displacement), row.is_right});
  }
  return judged;
}
std::vector<JudgedDetection> judge(const AcceptanceModel& model,
                                   const std::vector<LabelledFeatures>& rows) {
  std::vector<double> log_odds;
  for (const LabelledFeatures& row : rows) log_odds.push_back(model.log_odds(row.features));
  return judge(model, rows, log_odds);
}

/// The lowest threshold that lets through at most kMostFalse wrong detections per frame.
double threshold_for(const std::vector<JudgedDetection>& judged, int frames) {
  std::vector<double> wrong;
  for (const JudgedDetection& detection : judged) {
    if (!detection.is_right) wrong.push_back(detection.probability);
  }
  std::sort(wrong.begin(), wrong.end(), std::greater<>());
  const auto allowed = static_cast<std::size_t>(kMostFalse * frames);
  return allowed < wrong.size() ? std::max(wrong[allowed], 0.05) : 0.05;
}

void print_reliability(const std::vector<JudgedDetection>& judged) {
  constexpr std::array<double, 9> kEdges = {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.99, 1.01};
  fmt::print("predicted     detections  mean predicted  right\n");
  for (std::size_t bin = 0; bin + 1 < kEdges.size(); ++bin) {
    int count = 0;
    int right = 0;
    double sum = 0.0;
    for (const JudgedDetection& detection : judged) {
      const double p = detection.probability;
      if (p < kEdges[bin] || p >= kEdges[bin + 1]) continue;
      ++count;
      if (detection.is_right) ++right;
      sum += p;
    }
    if (count == 0) continue;
    fmt::print("{:.2f} - {:.2f} {:>12} {:>15.3f} {:>6.3f}\n", kEdges[bin],
               std::min(kEdges[bin + 1], 1.0), count, sum / count,
               static_cast<double>(right) / count);
  }
}

void print_rates(const std::vector<JudgedDetection>& judged, int frames) {
  fmt::print("least probability  right  wrong  of {} frames\n", frames);
  for (const double least : {0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995}) {
    int right = 0;
    int wrong = 0;
    for (const JudgedDetection& detection : judged) {
      if (detection.probability >= least) ++(detection.is_right ? right : wrong);
    }
    fmt::print("{:>17.3f} {:>6} {:>6}\n", least, right, wrong);
  }
}

/// Who loses what is not found: the generation of hypotheses or their acceptance.
void print_losses(const std::vector<FrameRows>& frames) {
  fmt::print("visible       instances  with a candidate  selected at 0.05\n");
  constexpr std::array<double, 5> kEdges = {0.15, 0.3, 0.5, 0.7, 1.01};
  for (std::size_t bin = 0; bin + 1 < kEdges.size(); ++bin) {
    int all = 0;
    int candidates = 0;
    int selected = 0;
    for (const FrameRows& frame : frames) {
      for (const FrameRows::Instance& instance : frame.instances) {
        if (instance.visible_share < kEdges[bin] || instance.visible_share >= kEdges[bin + 1]) {
          continue;
        }
        ++all;
        if (instance.was_candidate) ++candidates;
        if (instance.is_selected) ++selected;
      }
    }
    fmt::print("{:.2f} - {:.2f} {:>12} {:>17} {:>17}\n", kEdges[bin],
               std::min(kEdges[bin + 1], 1.0), all, candidates, selected);
  }
}

void write_rows(const std::filesystem::path& path, const std::vector<LabelledFeatures>& rows) {
  std::ofstream file(path);
  for (const LabelledFeatures& row : rows) {
    file << fmt::format("{},{},{:d},{},{:.5g},{:.5g}", row.scan, recipe_of(row.scan).variant,
                        row.is_right, row.weight, row.margin, row.displacement);
    for (const double value : row.features) file << fmt::format(",{:.5g}", value);
    file << '\n';
  }
  if (!file) throw IoError(path.string() + ": cannot be written");
}

std::string source_of(const AcceptanceModel& model, const Arguments& arguments) {
  std::string text = fmt::format(
      "// Written by recognition_calibration --scenes {} --passes {}\n"
      "// (tests/recognition/acceptance_calibration_main.cpp); not edited by hand.\n\n"
      "#include \"recognition/acceptance_model.h\"\n\n"
      "// clang-format off\nnamespace binpick {{\n\n"
      "const AcceptanceModel& calibrated_acceptance() {{\n"
      "  static const AcceptanceModel model = {{\n"
      "    .bias = {:.6g},\n"
      "    // low, high, centre, scale, slope, knots, bends\n"
      "    .terms = {{{{\n",
      arguments.scenes, arguments.passes, model.bias);
  for (const AcceptanceModel::Term& t : model.terms) {
    text += fmt::format(
        "      {{{:.6g}, {:.6g}, {:.6g}, {:.6g}, {:.6g}, {{{:.6g}, {:.6g}, {:.6g}}}, {{{:.6g}, "
        "{:.6g}, {:.6g}}}}},\n",
        t.low, t.high, t.centre, t.scale, t.slope, t.knots[0], t.knots[1], t.knots[2], t.bends[0],
        t.bends[1], t.bends[2]);
  }
  text += fmt::format(
      "    }}}},\n    .in_set = {{{:.6g}, {:.6g}, {:.6g}}},\n    .least_probability = "
      "{:.6g},\n"
      "  }};\n  return model;\n}}\n\n}}  // namespace binpick\n// clang-format on\n",
      model.in_set.bias, model.in_set.log_odds, model.in_set.margin, model.least_probability);
  return text;
}

int calibrate(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Fits the acceptance of hypotheses on generated scans and writes its weights");
  app.add_option("--scenes", arguments.scenes, "per pass")->check(CLI::PositiveNumber);
  app.add_option("--passes", arguments.passes, "each with the model of the one before")
      ->check(CLI::PositiveNumber);
  app.add_flag("--continue", arguments.from_calibrated,
               "start from the calibrated model: to look at what it does");
  app.add_option("--jobs", arguments.jobs, "threads")->check(CLI::PositiveNumber);
  app.add_option("--out", arguments.out,
                 "source file to write, recognition/acceptance_weights.cpp");
  app.add_option("--rows", arguments.rows,
                 "CSV of what the model was fitted to: scan, variant, right, weight, margin, "
                 "displacement, features");
  CLI11_PARSE(app, argc, argv);
  // Master seeds 900 to 949 are calibration's alone; nothing else is tuned or reported on them.
  constexpr Seed kFirstMaster = 900;
  const Calibration calibration(arguments);
  AcceptanceModel model = arguments.from_calibrated ? calibrated_acceptance() : starting_model();
  std::vector<LabelledFeatures> rows;
  for (int pass = 0; pass < arguments.passes; ++pass) {
    const std::vector<FrameRows> frames =
        calibration.collect(model, kFirstMaster + static_cast<Seed>(pass));
    std::vector<LabelledFeatures> selected;
    for (const FrameRows& frame : frames) {
      append(rows, frame.candidates);
      append(selected, frame.selected);
    }
    print_losses(frames);
    if (pass > 0) {
      fmt::print("pass {}: the model of the pass before on fresh scans\n", pass + 1);
      print_reliability(judge(model, selected));
      print_rates(judge(model, selected), arguments.scenes);
      append(rows, selected);
    }
    model = fit_acceptance(rows, kRidge);
    // Confidence is that of a detection, not of any hypothesis.
    std::vector<JudgedRow> unseen = cross_validate(rows, selected);
    const Recalibration recalibration = recalibration_of(unseen);
    recalibration.apply(model);
    std::vector<double> log_odds;
    for (JudgedRow& row : unseen) {
      row.log_odds = recalibration.a * row.log_odds + recalibration.b;
      log_odds.push_back(row.log_odds);
    }
    model.in_set = fit_in_set(unseen);
    const std::vector<JudgedDetection> judged = judge(model, selected, log_odds);
    model.least_probability = threshold_for(judged, arguments.scenes);
    fmt::print("pass {}: {} hypotheses, {} selected, least probability {:.3f}; cross-validated\n",
               pass + 1, rows.size(), selected.size(), model.least_probability);
    print_rates(judged, arguments.scenes);
  }
  if (!arguments.rows.empty()) write_rows(arguments.rows, rows);
  if (!arguments.out.empty()) {
    std::ofstream file(arguments.out);
    file << source_of(model, arguments);
    if (!file) throw IoError(arguments.out.string() + ": cannot be written");
  }
  return 0;
}

}  // namespace
}  // namespace binpick::testing

int main(int argc, char** argv) {
  try {
    return binpick::testing::calibrate(argc, argv);
  } catch (const binpick::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  } catch (const binpick::IoError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
}
