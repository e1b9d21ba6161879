#include "experiments/recognition_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <optional>
#include <span>
#include <string>

#include "experiments/recognition_objects.h"
#include "experiments/timing_turn.h"
#include "experiments/trial_setup.h"
#include "sim/png_writer.h"

namespace binpick {
namespace {

constexpr double kVisibleShare = 0.30;
constexpr double kHiddenShare = 0.15;

constexpr std::array<std::pair<const char*, RecognitionFigure>, 6> kFigures{{
    {"recall", RecognitionFigure::kRecall},
    {"threshold", RecognitionFigure::kThreshold},
    {"noise", RecognitionFigure::kNoise},
    {"occlusion", RecognitionFigure::kOcclusion},
    {"points", RecognitionFigure::kPoints},
    {"cores", RecognitionFigure::kCores},
}};

double cpu_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Pixels of the objects, by object.
std::vector<std::vector<std::size_t>> object_pixels(const SegmentationImage& image,
                                                    std::size_t objects) {
  std::vector<std::vector<std::size_t>> pixels(objects);
  for (std::size_t i = 0; i < image.object.size(); ++i) {
    if (image.object[i] >= 0) pixels[static_cast<std::size_t>(image.object[i])].push_back(i);
  }
  return pixels;
}

Eigen::Vector3d pixel_point(const RangeImage& image, std::size_t pixel) {
  const auto width = static_cast<std::size_t>(image.intrinsics.width);
  return image.p_camera(static_cast<int>(pixel % width), static_cast<int>(pixel / width));
}

double box_diagonal(const RangeImage& image,
                    const std::vector<std::vector<std::size_t>>& pixels_of_objects) {
  Eigen::AlignedBox3d box;
  for (const auto& pixels : pixels_of_objects) {
    for (const std::size_t pixel : pixels) box.extend(pixel_point(image, pixel));
  }
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

/// IJRR 2012, eq. (16): measured points of an object against the same points of its model, the
/// latter moved by the estimated pose.
double rms_of(const RangeImage& ideal, const std::vector<std::size_t>& pixels, double sigma,
              Seed noise, const Eigen::Isometry3d& T_true, const Eigen::Isometry3d& T_estimated) {
  std::vector<Eigen::Vector3d> p;
  std::vector<Eigen::Vector3d> q;
  for (const std::size_t pixel : pixels) {
    if (ideal.depth[pixel] <= 0.0f) continue;
    p.push_back(gaussian_point(ideal, pixel, sigma, noise));
    q.push_back(T_true.inverse() * pixel_point(ideal, pixel));
  }
  return p.empty() ? 0.0 : rms_error(p, q, T_estimated);
}

/// The pose under the symmetry that comes nearest to the truth.
Eigen::Isometry3d nearest_equivalent(const Eigen::Isometry3d& T,
                                     const std::vector<Eigen::Isometry3d>& symmetries,
                                     const Eigen::Isometry3d& T_true) {
  Eigen::Isometry3d nearest = T;
  for (const Eigen::Isometry3d& symmetry : symmetries) {
    const Eigen::Isometry3d candidate = T * symmetry;
    const auto distance = [&](const Eigen::Isometry3d& each) {
      return (each.matrix() - T_true.matrix()).squaredNorm();
    };
    if (distance(candidate) < distance(nearest)) nearest = candidate;
  }
  return nearest;
}

/// Pictures of a trial that is reproduced: what the camera would see without errors, what the
/// sensor made of it, and which pixels are whose.
void write_pictures(const std::filesystem::path& folder, const CleanView& view, const Scan& scan,
                    const SegmentationImage& owners) {
  std::filesystem::create_directories(folder);
  write_png(folder / "ideal.png", false_colour(view.image));
  write_png(folder / "objects.png", false_colour(owners));
  if (const auto* image = std::get_if<RangeImage>(&scan)) {
    write_png(folder / "scan.png", false_colour(*image));
  }
}

void add_counts(const CleanView& view, const RecognitionJudgement& judgement,
                const std::vector<std::string>& searched, TrialRecord& record) {
  std::map<std::string, double>& measures = record.measures;
  for (const char* name : {"visible", "visible_found", "hidden", "hidden_found"}) {
    measures[name] = 0.0;
  }
  for (std::size_t i = 0; i < view.objects.size(); ++i) {
    const TrueObject& object = view.objects[i];
    if (std::find(searched.begin(), searched.end(), object.model) == searched.end()) continue;
    const RecognitionJudgement::Match* match = judgement.match_of(i);
    if (object.visible_share >= kHiddenShare) {
      const std::string group = object.visible_share >= kVisibleShare ? "visible" : "hidden";
      measures[group] += 1.0;
      measures[group + "_found"] += match != nullptr ? 1.0 : 0.0;
    }
    if (match == nullptr) continue;
    measures[fmt::format("position_m.{}", i)] = match->error.translation;
    measures[fmt::format("rotation_rad.{}", i)] = match->error.rotation;
  }
  measures["false_positives"] = static_cast<double>(judgement.false_positives);
}

/// What was wrongly found, where in the camera's frame, and how sure the recognizer was.
std::string false_detections(const RecognitionJudgement& judgement,
                             std::span<const Detection> detections) {
  std::vector<std::string> wrong;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    const bool is_right = std::any_of(judgement.matches.begin(), judgement.matches.end(),
                                      [i](const auto& match) { return match.detection == i; });
    if (is_right) continue;
    const Detection& detection = detections[i];
    const Eigen::Vector3d p = detection.T_scene_model.translation();
    wrong.push_back(fmt::format("{} at ({:.3f}, {:.3f}, {:.3f}) m, confidence {:.2f}",
                                detection.model, p.x(), p.y(), p.z(), detection.confidence));
  }
  return fmt::format("false: {}", fmt::join(wrong, "; "));
}

void decide(const CleanView& view, const RecognitionJudgement& judgement,
            std::span<const Detection> detections, TrialRecord& record) {
  const std::map<std::string, double>& measures = record.measures;
  const double missed = measures.at("visible") - measures.at("visible_found");
  if (view.target >= 0) {
    const auto target = static_cast<std::size_t>(view.target);
    record.note = fmt::format("{} at an occlusion of {:.1f} %", view.objects[target].model,
                              100.0 * view.objects[target].occlusion);
    if (judgement.match_of(target) == nullptr) {
      fail(record, TrialOutcome::kNothingDetected, TrialStage::kRecognize, record.note);
    }
  } else if (missed > 0.0) {
    fail(record, TrialOutcome::kNothingDetected, TrialStage::kRecognize,
         fmt::format("{} of {} visible objects missed", missed, measures.at("visible")));
  } else if (judgement.false_positives > 0) {
    fail(record, TrialOutcome::kWrongPose, TrialStage::kRecognize,
         false_detections(judgement, detections));
  }
}

}  // namespace

void RecognitionTrial::visit(ConfigVisitor& visitor) {
  visitor.text("scene", scene_, Presence::kRequired);
  std::vector<std::string> figures;
  for (const auto& [name, figure] : kFigures) figures.emplace_back(name);
  visitor.choice("figure", figure_, figures);
  visitor.choice("setting", setting_, {"paper", "default"});
  visitor.boolean("timed", timed_);
  visitor.group("conditions", [&](ConfigVisitor& group) { base_.visit(group); });
  visitor.list(
      "variants", variants_.size(),
      [&](std::size_t size) {
        variants_.assign(size, Variant{"", base_});
      },
      [&](ConfigVisitor& element, std::size_t i) {
        element.text("name", variants_[i].name, Presence::kRequired);
        variants_[i].conditions.visit(element);
      });
  visitor.text("variant", variant_);
  if (!visitor.reading() || variant_.empty()) return;
  const auto is_selected = [&](const Variant& each) { return each.name == variant_; };
  if (std::none_of(variants_.begin(), variants_.end(), is_selected)) {
    visitor.problem("variant", fmt::format("'{}' is none of the variants", variant_));
  }
}

const RecognitionConditions& RecognitionTrial::conditions() const {
  const auto found = std::find_if(variants_.begin(), variants_.end(),
                                  [&](const Variant& each) { return each.name == variant_; });
  return found == variants_.end() ? base_ : found->conditions;
}

RecognitionFigure RecognitionTrial::figure() const {
  return std::find_if(kFigures.begin(), kFigures.end(),
                      [&](const auto& each) { return each.first == figure_; })
      ->second;
}

std::vector<std::filesystem::path> RecognitionTrial::input_files(
    const std::filesystem::path& config_directory) const {
  std::vector<std::filesystem::path> files = trial_input_files(config_directory / scene_);
  const std::vector<std::filesystem::path> toys = toy_files();
  files.insert(files.end(), toys.begin(), toys.end());
  std::sort(files.begin(), files.end());
  return files;
}

const RecognitionTrial::Searched& RecognitionTrial::searched() {
  const RecognitionConditions& now = conditions();
  const std::vector<std::string> names = now.searched_models();
  Searched& searched =
      searched_[fmt::format("{} {} {}", fmt::join(names, " "), now.model_scale, setting_)];
  if (searched.library) return searched;
  std::vector<ModelSource> sources;
  std::vector<ObjectModel> objects;
  for (const std::string& name : names) {
    objects.push_back(recognition_object(name));
    TriangleMesh mesh = objects.back().mesh;
    for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= now.model_scale;
    sources.push_back({name, std::move(mesh), objects.back().symmetries});
  }
  const bool paper = setting_ == "paper";
  searched.library = std::make_shared<const ModelLibrary>(
      sources, paper ? RecognizerSetting::kPaper : RecognizerSetting::kDefault);
  searched.judge = std::make_shared<const RecognitionJudge>(objects);
  return searched;
}

void RecognitionTrial::prepare(const std::filesystem::path& config_directory) {
  const RecognitionConditions& now = conditions();
  std::unique_ptr<RecognitionScenes>& scenes = scenes_[config_directory / scene_];
  if (!scenes) scenes = std::make_unique<RecognitionScenes>(config_directory / scene_);
  scenes_in_use_ = scenes.get();
  RecognizerOptions options;
  options.setting = setting_ == "paper" ? RecognizerSetting::kPaper : RecognizerSetting::kDefault;
  options.visibility = now.visibility;
  options.jobs = static_cast<int>(now.jobs);
  recognizer_ = std::make_shared<const Recognizer>(searched().library, options);
  judge_ = searched().judge;
}

const RecognitionTrial::Observation& RecognitionTrial::observe(Seed pile, Seed sensor) {
  const RecognitionConditions now = conditions().of_scan();
  if (last_ && last_->conditions == now && last_->pile == pile && last_->sensor == sensor) {
    return *last_;
  }
  last_.reset();
  Observation seen{now, pile, sensor, scenes_in_use_->view(now, pile), {}, {}, 0.0, {}};
  seen.owners = scenes_in_use_->segmentation();
  seen.pixels = object_pixels(seen.owners, seen.view.objects.size());
  seen.diagonal = box_diagonal(seen.view.image, seen.pixels);
  seen.scan = measure(seen.view.image, now, seen.diagonal, sensor);
  if (now.objects_only) keep_objects_only(std::get<RangeImage>(seen.scan), seen.owners);
  return last_.emplace(std::move(seen));
}

RecognitionResult RecognitionTrial::recognize(const Scan& scan, Seed seed) const {
  if (const auto* cloud = std::get_if<PointCloud>(&scan)) {
    return recognizer_->recognize(*cloud, Eigen::Vector3d::Zero(), seed);
  }
  return recognizer_->recognize(std::get<RangeImage>(scan), seed);
}

TrialRecord RecognitionTrial::run(const TrialContext& context) {
  TrialRecord record;
  const RecognitionConditions& now = conditions();
  context.enter(TrialStage::kSetup);
  std::optional<TimingTurn> turn;
  if (timed_) turn.emplace();
  const bool fixed = now.scene_seed > 0;
  const Seed pile =
      fixed ? derive_seed(static_cast<Seed>(now.scene_seed), "pile") : context.seeds.shared("pile");
  const Observation& seen = observe(pile, context.seeds.shared("sensor"));
  const CleanView& view = seen.view;
  if (context.trace) write_pictures(*context.trace, view, seen.scan, seen.owners);

  context.enter(TrialStage::kRecognize);
  const auto started = std::chrono::steady_clock::now();
  const double cpu_started = cpu_seconds();
  const RecognitionResult found = recognize(seen.scan, context.seeds.shared("recognizer"));
  const double cpu = cpu_seconds() - cpu_started;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - started;

  context.enter(TrialStage::kJudge);
  const RecognitionJudgement judgement = judge_->judge(found.detections, view.objects);
  add_counts(view, judgement, now.searched_models(), record);
  record.measures["pairs"] = found.counters.pairs;
  record.measures["scene_points"] = static_cast<double>(point_count(seen.scan));
  if (view.target >= 0) {
    record.measures["target_occlusion"] = view.objects[std::size_t(view.target)].occlusion;
  }
  if (now.sensor == "gaussian") {
    for (const RecognitionJudgement::Match& match : judgement.matches) {
      const TrueObject& object = view.objects[match.object];
      const Eigen::Isometry3d T =
          nearest_equivalent(found.detections[match.detection].T_scene_model,
                             judge_->symmetries(object.model), object.T_camera_model);
      record.measures[fmt::format("rms_share.{}", match.object)] =
          rms_of(view.image, seen.pixels[match.object], now.gaussian * seen.diagonal, seen.sensor,
                 object.T_camera_model, T) /
          seen.diagonal;
      record.measures[fmt::format("position_share.{}", match.object)] =
          match.error.translation / seen.diagonal;
    }
  }
  if (timed_) {
    record.measures["wall_s"] = wall.count();
    record.measures["cpu_s"] = cpu;
  }
  decide(view, judgement, found.detections, record);
  return record;
}

}  // namespace binpick
