#include "recognition/evaluation_diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "recognition/acceptance_function.h"
#include "recognition/acceptance_model.h"
#include "recognition/cloud_projection.h"
#include "recognition/depth_rasterizer.h"
#include "recognition/hypothesis_clusters.h"
#include "recognition/observed_scene.h"
#include "recognition/pair_descriptor.h"

namespace binpick::testing {
namespace {

constexpr std::array<const char*, kFeatures> kFeatureNames = {
    "evidence",  "typical",     "matched",   "bad_normal", "through",    "through_rim",
    "near_occl", "claimed",     "continued", "edges",      "open",       "agree",
    "missed",    "edge_offset", "spread",    "res_bias",   "res_spread", "normal_err",
    "faces",     "unseen",      "fixed",     "resolution"};

constexpr double kNearTruth = 0.1;  // diameters

/// The scene as the recognizer sees it.
struct View {
  RangeImage image;
  Eigen::Isometry3d T_scene_camera = Eigen::Isometry3d::Identity();
};
View view_of(const SyntheticFrame& frame) {
  if (frame.parameters.form == ScanForm::kRangeImage) return {frame.image, frame.T_scene_camera};
  ProjectedCloud projected = project_cloud(frame.cloud, frame.p_scene_viewpoint);
  return {std::move(projected.image), projected.T_cloud_camera};
}

ObservedScene observe(const View& view, const ModelLibrary& library) {
  double face = 0.0;
  for (const RecognitionModel& model : library.models()) {
    face = std::max(face, static_cast<double>(model.largest_face));
  }
  return {view.image, {library.leaf_size(), 2.5 * face}, 1, 1};
}

/// The log odds, and the features that spoke loudest against.
std::string odds_of(const FeatureVector& features) {
  const AcceptanceModel& acceptance = calibrated_acceptance();
  const double total = acceptance.log_odds(features);
  std::array<double, kFeatures> parts{};
  for (std::size_t i = 0; i < kFeatures; ++i) {
    FeatureVector best = features;
    const AcceptanceModel::Term& term = acceptance.terms[i];
    best[i] = direction_of(static_cast<Feature>(i)) > 0.0 ? term.high : term.low;
    parts[i] = total - acceptance.log_odds(best);
  }
  std::array<std::size_t, kFeatures> order{};
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return parts[a] < parts[b]; });
  std::string text = fmt::format("odds {:.1f};", total);
  for (std::size_t i = 0; i < 4; ++i) {
    text += fmt::format(" {} {:.2f} ({:+.1f})", kFeatureNames[order[i]], features[order[i]],
                        parts[order[i]]);
  }
  return text;
}

const RecognitionModel& model_of(const ModelLibrary& library, const std::string& name) {
  return *std::find_if(library.models().begin(), library.models().end(),
                       [&](const RecognitionModel& model) { return model.name == name; });
}

/// Share of the instance's pixels in the working image that count as support plane.
double support_share(const ObservedScene& scene, const RecognitionModel& model,
                     const Eigen::Isometry3f& T) {
  DepthRasterizer rasterizer;
  const RenderedModel& rendered = rasterizer.render(model.render_mesh, T, scene.projection());
  int own = 0;
  int support = 0;
  for (int v = 0; v < rendered.height; ++v) {
    for (int u = 0; u < rendered.width; ++u) {
      if (!rendered.covers(u, v)) continue;
      const ScenePixel& pixel =
          scene.pixel((rendered.v0 + v) * scene.projection().width + rendered.u0 + u);
      if (std::abs(pixel.depth - rendered.depth[rendered.index(u, v)]) > 0.01f) continue;
      ++own;
      if ((pixel.flags & ScenePixel::kSupport) != 0) ++support;
    }
  }
  return own > 0 ? static_cast<double>(support) / own : 0.0;
}

/// What becomes of point pairs that lie on the instance: how many of its leaves can be sampled, and
/// which share of its pairs leads to a hypothesis near the truth that stands the cascade.
std::string pair_statistics(const SyntheticFrame& frame, std::size_t instance,
                            const ObservedScene& scene, const ModelLibrary& library,
                            const Eigen::Isometry3d& T_true) {
  constexpr int kPairs = 300;
  constexpr double kNear = 0.15;  // diameters: what alignment can mend
  if (frame.parameters.form != ScanForm::kRangeImage) return {};
  const std::size_t M = frame.scene.instances[instance].model;
  const RecognitionModel& model = library.models()[M];
  const CameraIntrinsics& camera = frame.image.intrinsics;
  const Projection projection = projection_of(camera);
  std::vector<int> own;
  int sampled = 0;
  for (const int leaf : scene.object_leaves()) {
    if (!scene.normal_is_reliable(leaf)) continue;
    ++sampled;
    const int pixel = projection.pixel(scene.octree().point(leaf));
    if (pixel >= 0 &&
        frame.scene.clean.owner[static_cast<std::size_t>(pixel)] == static_cast<int>(instance)) {
      own.push_back(leaf);
    }
  }
  const auto d = static_cast<float>(library.pair_width());
  const float tolerance =
      std::max(static_cast<float>(library.pair_tolerance()), 0.5f * scene.octree().leaf_size());
  const float coarse = tolerances_for(model, scene.noise()).coarse;
  Random random(1);
  int tried = 0, pairs = 0, near = 0, stood = 0;
  while (tried < kPairs && !own.empty()) {
    ++tried;
    const int a = own[random.index(own.size())];
    const OrientedPoint u{scene.octree().point(a), scene.normal(a)};
    std::vector<int> shell;
    for (const int b : own) {
      if (std::abs((scene.octree().point(b) - u.p).norm() - d) < tolerance) shell.push_back(b);
    }
    if (shell.empty()) continue;
    const int b = shell[random.index(shell.size())];
    const OrientedPoint v{scene.octree().point(b), scene.normal(b)};
    const PairDescriptor f = pair_descriptor(u, v);
    const auto frame_uv = pair_frame(u, v);
    if (is_coplanar(f) || !frame_uv) continue;
    ++pairs;
    bool is_near = false, stands = false;
    for (const PairFrame& inverse : library.pairs().pairs(PairTable::cell(f), M)) {
      Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
      T.linear() = frame_uv->linear() * inverse.leftCols<3>();
      T.translation() = frame_uv->linear() * inverse.col(3) + frame_uv->translation();
      if (mssd(T.cast<double>(), T_true, model.hull, model.symmetries) >
          kNear * static_cast<double>(model.diameter)) {
        continue;
      }
      is_near = true;
      stands = stands || (!sinks_into_support(scene, model, T, 0.05f * model.diameter) &&
                          test_in_cascade(scene, model, T, {coarse, 0.18f, 0.2f}));
    }
    near += is_near ? 1 : 0;
    stood += stands ? 1 : 0;
  }
  return fmt::format(
      "; {} of {} sampled leaves; of {} points {} make a pair, {} come near, {} stand", own.size(),
      sampled, tried, pairs, near, stood);
}

/// Of the hypotheses near the truth the most credible, of others the nearest; and how far it is
/// off, in diameters.
std::pair<const ConsideredHypothesis*, double> most_credible_near(const Eigen::Isometry3d& T_true,
                                                                  const RecognitionModel& model,
                                                                  const RecognitionResult& result) {
  std::pair<const ConsideredHypothesis*, double> found{nullptr,
                                                       std::numeric_limits<double>::infinity()};
  double best = -std::numeric_limits<double>::infinity();
  for (const ConsideredHypothesis& considered : result.considered) {
    if (considered.model != model.name) continue;
    const double error = mssd(considered.T_camera_model, T_true, model.hull, model.symmetries) /
                         static_cast<double>(model.diameter);
    const double credibility =
        error < kNearTruth ? calibrated_acceptance().log_odds(considered.features) : -1e3 * error;
    if (credibility <= best) continue;
    best = credibility;
    found = {&considered, error};
  }
  return found;
}

}  // namespace

std::string diagnose_miss(const SyntheticFrame& frame, std::size_t instance,
                          const RecognitionResult& result, const ModelLibrary& library) {
  const TrueInstance& truth = frame.scene.instances[instance];
  const RecognitionModel& model = library.models()[truth.model];
  const View view = view_of(frame);
  const Eigen::Isometry3d T_true =
      view.T_scene_camera.inverse() * frame.T_scene_camera * truth.T_camera_model;
  const auto [nearest, least] = most_credible_near(T_true, model, result);
  const ObservedScene scene = observe(view, library);
  const Eigen::Isometry3f T = T_true.cast<float>();
  std::string text =
      fmt::format("miss {} shows {:.2f}, {:.2f} of it taken for support: ", model.name,
                  truth.visible_share, support_share(scene, model, T));
  if (nearest != nullptr && least < kNearTruth) {
    return text +
           fmt::format("{} at {:.3f} diameters, ", nearest->is_selected ? "SELECTED" : "REJECTED",
                       least) +
           odds_of(nearest->features);
  }
  text += fmt::format("NOT GENERATED (nearest {:.2f} diameters), ", least);
  const float coarse = tolerances_for(model, scene.noise()).coarse;
  if (sinks_into_support(scene, model, T, 0.05f * model.diameter)) text += "sinks into support, ";
  const FacingCounts counts = count_facing(scene, model, T, coarse, 0, model.test_points.size());
  return text +
         fmt::format("cascade at the truth {}, score {:.2f}",
                     test_in_cascade(scene, model, T, {coarse, 0.18f, 0.2f}) ? "passes" : "FAILS",
                     counts.score()) +
         fmt::format("; {} pairs drawn", result.counters.pairs) +
         pair_statistics(frame, instance, scene, library, T_true);
}

std::string diagnose_false(const SyntheticFrame& frame, std::size_t detection,
                           const RecognitionResult& result, const ModelLibrary& library) {
  const Detection& found = result.detections[detection];
  const RecognitionModel& model = model_of(library, found.model);
  // What it lies on.
  const CameraIntrinsics& camera = frame.image.intrinsics;
  const Projection projection = projection_of(camera);
  const Eigen::Isometry3d T_camera_model = frame.T_scene_camera.inverse() * found.T_scene_model;
  DepthRasterizer rasterizer;
  const RenderedModel& rendered =
      rasterizer.render(model.render_mesh, T_camera_model.cast<float>(), projection);
  int known = 0, foreign = 0, ground = 0, all = 0;
  for (int v = 0; v < rendered.height; ++v) {
    for (int u = 0; u < rendered.width; ++u) {
      if (!rendered.covers(u, v)) continue;
      ++all;
      const auto pixel =
          static_cast<std::size_t>((rendered.v0 + v) * camera.width + rendered.u0 + u);
      if (std::abs(frame.scene.clean.image.depth[pixel] - rendered.depth[rendered.index(u, v)]) >
          0.01f) {
        continue;
      }
      const std::int16_t owner = frame.scene.clean.owner[pixel];
      ++(owner >= 0 ? known : owner == CleanFrame::kForeign ? foreign : ground);
    }
  }
  double least = std::numeric_limits<double>::infinity();
  for (const TrueInstance& truth : frame.scene.instances) {
    if (library.models()[truth.model].name != found.model) continue;
    least =
        std::min(least, mssd(T_camera_model, truth.T_camera_model, model.hull, model.symmetries) /
                            static_cast<double>(model.diameter));
  }
  const double whole = std::max(all, 1);
  std::string text = fmt::format(
      "false {} on known {:.2f} foreign {:.2f} ground {:.2f}, nearest truth {:.2f} diameters, "
      "confidence {:.2f}: ",
      model.name, known / whole, foreign / whole, ground / whole, least, found.confidence);
  const View view = view_of(frame);
  const ConsideredHypothesis* origin = nullptr;
  double closest = std::numeric_limits<double>::infinity();
  for (const ConsideredHypothesis& considered : result.considered) {
    if (considered.model != found.model || !considered.is_selected) continue;
    const double error = mssd(view.T_scene_camera * considered.T_camera_model, found.T_scene_model,
                              model.hull, model.symmetries);
    if (error < closest) {
      closest = error;
      origin = &considered;
    }
  }
  return origin != nullptr ? text + odds_of(origin->features) : text;
}

}  // namespace binpick::testing
