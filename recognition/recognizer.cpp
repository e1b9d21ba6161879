#include "recognition/recognizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "models/errors.h"
#include "recognition/acceptance_function.h"
#include "recognition/candidate_pool.h"
#include "recognition/cloud_projection.h"
#include "recognition/conflict_graph.h"
#include "recognition/iteration_count.h"
#include "recognition/joint_refinement.h"
#include "recognition/observed_scene.h"
#include "recognition/parallel_for.h"
#include "recognition/pose_refinement.h"
#include "recognition/pose_uncertainty.h"
#include "recognition/shell_sampler.h"
#include "recognition/stopwatch.h"

namespace binpick {
namespace {

constexpr double kPlaneAreaPerFace = 2.5;  // a support plane is larger than any face by this
// They keep a scene of pure clutter affordable.
constexpr int kMostIterations = 20000;
constexpr int kMostPerRound = 8000;
constexpr int kMostRounds = 8;       // of sampling, default setting
constexpr int kFlatIterations = 12;  // pairs on the unexplained rest, for single faces
constexpr int kMostFlatRounds = 4;
/// V of the points that face the sensor; less than 1, for of those some miss a normal or a pixel.
constexpr double kFacingShare = 0.6;
constexpr int kSpatialClusters = 30;  // looked at per round and model
constexpr int kFlatClusters = 12;
constexpr int kLeastRounds = 3;
constexpr double kLaterVisibility = 0.15;  // of V: what is still hidden then shows less

/// Accepts (M, T) or not; the accepted one comes back with its score.
using Mu = std::function<std::optional<Hypothesis>(int model, const Eigen::Isometry3f& T)>;

/// Which scene pairs are drawn, and where their model pairs come from.
enum class PairKind {
  kAny,      ///< as printed
  kSpatial,  ///< not in one plane: fixes a pose
  kFlat      ///< in one plane: the position in it is tried out
};

/// One run of Algorithm 1 on one scene.
class Run {
 public:
  Run(const ModelLibrary& library, const RecognizerOptions& options, const RangeImage& image,
      Seed seed)
      : library_(library),
        options_(options),
        seed_(seed),
        scene_(image, scale(), options.jobs, derive_seed(seed, "support planes")) {
    const ObservedScene::Timings& prepared = scene_.timings();
    result_.timings = {{"range_image", prepared.image},
                       {"octree", prepared.octree},
                       {"support_plane", prepared.planes},
                       {"normals", prepared.normals},
                       {"generate_and_test", 0.0},
                       {"verify", 0.0},
                       {"select", 0.0},
                       {"refine", 0.0}};
    result_.support_planes = scene_.support_planes();
    result_.counters.scene_points = scene_.octree().size();
    result_.counters.sampled_points = static_cast<int>(scene_.object_leaves().size());
  }

  RecognitionResult recognize() {
    if (scene_.object_leaves().empty()) {
      result_.note = scene_.octree().size() == 0 ? "the scene is empty"
                                                 : "nothing but support planes in the scene";
    } else if (options_.setting == RecognizerSetting::kPaper) {
      recognize_as_printed();
    } else {
      recognize_in_rounds();
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] SceneScale scale() const {
    double face = 0.0;
    for (const RecognitionModel& model : library_.models()) {
      face = std::max(face, static_cast<double>(model.largest_face));
    }
    return {library_.leaf_size(), kPlaneAreaPerFace * face};
  }

  void add_time(const char* stage, double seconds) {
    for (StageTiming& timing : result_.timings) {
      if (timing.stage == stage) timing.seconds += seconds;
    }
  }

  /// Line 3 of Algorithm 1, for pairs from `sampled` leaves. The least instance to be found shows a
  /// share `visibility` of the smallest surface.
  [[nodiscard]] int compute_iterations(std::size_t sampled, double visibility) const {
    const double leaf_area = std::pow(static_cast<double>(scene_.octree().leaf_size()), 2);
    double smallest = library_.models().front().area;
    for (const RecognitionModel& model : library_.models()) {
      smallest = std::min(smallest, static_cast<double>(model.area));
    }
    SamplingOdds odds;
    odds.scene_points = static_cast<double>(sampled);
    odds.instance_points = std::max(visibility * smallest / leaf_area, 1.0);
    odds.kept_fraction = std::max(library_.pairs().kept_fraction(), 1e-3);
    odds.same_object_share = options_.same_object_share;
    odds.success_probability = options_.success_probability;
    return static_cast<int>(std::min(iteration_count(odds), double{kMostIterations}));
  }

  /// Lines 4-20 of Algorithm 1: draws pairs with p_u from `sampled` (leaves of S*) and returns the
  /// solution list. Iterations are independent and own their random numbers by index.
  std::vector<Hypothesis> generate_and_test(const std::vector<int>& sampled, int iterations,
                                            Seed seed, const Mu& mu, PairKind kind);

  /// Lines 5-8: an oriented scene point pair (u, v), if the shell round p_u holds a wanted p_v.
  [[nodiscard]] std::optional<std::pair<OrientedPoint, OrientedPoint>> sample_pair(
      const std::vector<int>& sampled, const ShellSampler& shell, Random& random,
      PairKind kind) const;

  [[nodiscard]] OrientedPoint oriented_point(int leaf) const {
    return {scene_.octree().point(leaf), scene_.normal(leaf)};
  }

  /// Leaves that an oriented point pair may begin with.
  [[nodiscard]] std::vector<int> sampled_leaves() const {
    std::vector<int> leaves;
    for (const int leaf : scene_.object_leaves()) {
      if (scene_.is_open(leaf) && scene_.normal_is_reliable(leaf)) leaves.push_back(leaf);
    }
    return leaves;
  }

  void recognize_as_printed();
  void recognize_in_rounds();
  [[nodiscard]] std::vector<RefinedPose> final_poses(CandidatePool& pool) const;
  void report_selected(CandidatePool& pool);
  void keep_considered(const CandidatePool& pool, const std::vector<RefinedPose>& refined,
                       const std::vector<double>& displacements);
  [[nodiscard]] std::vector<int> explained_by(const Hypothesis& hypothesis) const;
  void report(int model, const Eigen::Isometry3d& T_camera_model, int explained_points);

  const ModelLibrary& library_;
  const RecognizerOptions& options_;
  const Seed seed_;
  ObservedScene scene_;
  RecognitionResult result_;
};

std::optional<std::pair<OrientedPoint, OrientedPoint>> Run::sample_pair(
    const std::vector<int>& sampled, const ShellSampler& shell, Random& random,
    PairKind kind) const {
  // 3) sampling
  const OrientedPoint u = oriented_point(sampled[random.index(sampled.size())]);  // line 5
  // 4) normal estimation: done for all points of S* beforehand                     // line 8
  static thread_local std::vector<int> L;
  shell.collect(u.p, L);  // line 6
  // If this p_v makes no pair of the wanted kind, another may.
  const std::size_t draws = std::min(L.size(), std::size_t{kind == PairKind::kAny ? 1u : 4u});
  for (std::size_t draw = 0; draw < draws; ++draw) {
    std::swap(L[draw], L[draw + random.index(L.size() - draw)]);
    const OrientedPoint v = oriented_point(L[draw]);  // line 7
    if (kind == PairKind::kAny) return std::pair(u, v);
    const bool is_flat = is_coplanar(pair_descriptor(u, v));
    if (is_flat == (kind == PairKind::kFlat)) return std::pair(u, v);  // line 9
  }
  return std::nullopt;
}

std::vector<Hypothesis> Run::generate_and_test(const std::vector<int>& sampled, int iterations,
                                               Seed seed, const Mu& mu, PairKind kind) {
  struct Iteration {
    std::optional<Eigen::Isometry3f> F_wx;
    std::uint32_t cell = 0;
    std::vector<Hypothesis> solutions;
  };
  // Of width d and tolerance delta_d.
  const ShellSampler shell(
      scene_.octree(), sampled, static_cast<float>(library_.pair_width()),
      std::max(static_cast<float>(library_.pair_tolerance()), 0.5f * scene_.octree().leaf_size()));
  std::vector<Iteration> all(static_cast<std::size_t>(iterations));
  std::vector<int> hypotheses(all.size(), 0);
  const auto model_pairs_of = [&](std::uint32_t cell, std::size_t M) -> std::span<const PairFrame> {
    return kind == PairKind::kFlat ? library_.coplanar_pairs(M) : library_.pairs().pairs(cell, M);
  };
  const auto draw = [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    Random random(derive_seed(seed, static_cast<std::uint64_t>(i)));
    const auto pair = sample_pair(sampled, shell, random, kind);  // lines 5-9
    if (!pair) return;
    all[index].F_wx = pair_frame(pair->first, pair->second);
    if (!all[index].F_wx) return;
    // 5) hash table access
    const PairDescriptor f_uv = pair_descriptor(pair->first, pair->second);  // line 10
    all[index].cell = PairTable::cell(f_uv);                                 // line 11
    for (std::size_t M = 0; M < library_.models().size(); ++M) {
      hypotheses[index] += static_cast<int>(model_pairs_of(all[index].cell, M).size());
    }
  };
  const auto test = [&](int i) {
    Iteration& iteration = all[static_cast<std::size_t>(i)];
    if (!iteration.F_wx) return;
    std::vector<Hypothesis> solutions;  // not shared yet: threads do not wait for cache lines
    for (std::size_t M = 0; M < library_.models().size(); ++M) {  // line 14
      // 6) generate and test
      for (const PairFrame& F_uv_inverse : model_pairs_of(iteration.cell, M)) {      // lines 12-13
        const Eigen::Isometry3f T = hypothesis_pose(*iteration.F_wx, F_uv_inverse);  // line 15
        if (auto accepted = mu(static_cast<int>(M), T)) {                            // line 16
          solutions.push_back(*accepted);                                            // line 17
        }
      }
    }
    iteration.solutions = std::move(solutions);
  };
  constexpr int kDrawsPerChunk = 8;
  // The iterations of line 4, drawn first: the cells' sizes differ by orders of magnitude.
  parallel_chunks(iterations, kDrawsPerChunk, options_.jobs, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) draw(i);
  });
  parallel_for_longest_first(hypotheses, options_.jobs, test);
  std::vector<Hypothesis> solutions;
  for (const Iteration& iteration : all) {
    solutions.insert(solutions.end(), iteration.solutions.begin(), iteration.solutions.end());
    result_.counters.pairs += iteration.F_wx ? 1 : 0;
  }
  result_.counters.hypotheses += std::accumulate(hypotheses.begin(), hypotheses.end(), 0);
  result_.counters.iterations += iterations;
  return solutions;
}

/// Algorithm 1 as printed.
void Run::recognize_as_printed() {
  Stopwatch watch;
  // 1) initialization (lines 1-2): scene_ holds the octree and S*
  // 2) number of iterations
  const std::vector<int>& sampled = scene_.object_leaves();
  const int N = compute_iterations(sampled.size(), options_.visibility);  // line 3
  std::vector<ModelTolerances> tolerances;
  for (const RecognitionModel& model : library_.models()) {
    tolerances.push_back(tolerances_for(model, scene_.noise()));
  }
  const Mu mu = [&](int M, const Eigen::Isometry3f& T) -> std::optional<Hypothesis> {
    const auto index = static_cast<std::size_t>(M);
    const Acceptance terms =
        evaluate_acceptance(scene_, library_.models()[index], T, tolerances[index].coarse);
    if (!terms.accepts(options_.visibility, options_.penalty)) return std::nullopt;
    return Hypothesis{M, T, static_cast<float>(terms.visibility)};
  };
  const std::vector<Hypothesis> solutions =
      generate_and_test(sampled, N, derive_seed(seed_, "pairs"), mu, PairKind::kAny);
  result_.counters.accepted = static_cast<int>(solutions.size());
  add_time("generate_and_test", watch.lap());

  // 7) removing conflicting hypotheses (line 21)
  std::vector<ExplainedSet> explained(solutions.size());
  parallel_for(static_cast<int>(solutions.size()), options_.jobs, [&](int i) {
    ExplainedSet& set = explained[static_cast<std::size_t>(i)];
    set.points = explained_by(solutions[static_cast<std::size_t>(i)]);
    set.quality = static_cast<double>(set.points.size());
  });
  std::vector<int> sizes;
  sizes.reserve(explained.size());
  for (const ExplainedSet& set : explained) sizes.push_back(static_cast<int>(set.points.size()));
  const std::vector<int> kept = suppress_non_maxima(explained);
  add_time("select", watch.lap());
  for (const int node : kept) {
    const auto index = static_cast<std::size_t>(node);
    const Hypothesis& solution = solutions[index];
    const Eigen::Isometry3d T = solution.T_camera_model.cast<double>();
    const auto M = static_cast<std::size_t>(solution.model);
    report(solution.model,
           options_.refine ? refine_pose(scene_, library_.models()[M], T,
                                         static_cast<double>(tolerances[M].fine))
                           : T,
           sizes[index]);
  }
  add_time("refine", watch.lap());
}

/// Algorithm 1 in rounds: the hypotheses of a round are clustered, aligned and verified by
/// rendering before conflicts are removed, and the next one searches what the detections so far
/// leave unexplained, with the N of eq. (11) that so small a rest asks for.
void Run::recognize_in_rounds() {
  Stopwatch watch;
  const auto& models = library_.models();
  const auto facing = static_cast<float>(kFacingShare * options_.visibility);
  std::vector<FacingThresholds> thresholds;
  thresholds.reserve(models.size());
  for (const RecognitionModel& model : models) {
    thresholds.push_back({tolerances_for(model, scene_.noise()).coarse, facing, 0.2f});
  }
  const Mu mu = [&](int M, const Eigen::Isometry3f& T) -> std::optional<Hypothesis> {
    const auto index = static_cast<std::size_t>(M);
    const RecognitionModel& model = models[index];
    if (sinks_into_support(scene_, model, T, 0.05f * model.diameter)) return std::nullopt;
    const auto counts = test_in_cascade(scene_, model, T, thresholds[index]);
    if (!counts) return std::nullopt;
    return Hypothesis{M, T, counts->score()};
  };
  const AcceptanceModel& acceptance =
      options_.acceptance != nullptr ? *options_.acceptance : calibrated_acceptance();
  CandidatePool pool(library_, scene_, acceptance, facing, options_.jobs);
  std::vector<int> sampled = sampled_leaves();
  const auto sample_round = [&](int round, int count, PairKind kind, int most_clusters) {
    const Seed seed = derive_seed(derive_seed(seed_, "pairs"), static_cast<std::uint64_t>(round));
    std::vector<Hypothesis> solutions = generate_and_test(sampled, count, seed, mu, kind);
    add_time("generate_and_test", watch.lap());
    const bool has_grown = pool.add(std::move(solutions), most_clusters, kind == PairKind::kFlat);
    add_time("verify", watch.lap());
    if (!has_grown) return;
    std::vector<int> explained;
    for (const SelectedCandidate& candidate : pool.select()) {
      explained.insert(explained.end(), candidate.pixels.begin(), candidate.pixels.end());
    }
    scene_.set_explained(explained);
    sampled = sampled_leaves();
    add_time("select", watch.lap());
  };
  for (int round = 0; round < kMostRounds && !sampled.empty(); ++round) {
    const std::size_t before = pool.selected().size();
    const double V = (round == 0 ? 1.0 : kLaterVisibility) * options_.visibility;
    const int N = std::min(compute_iterations(sampled.size(), V), kMostPerRound);
    sample_round(round, N, PairKind::kSpatial, kSpatialClusters);
    if (round + 1 >= kLeastRounds && pool.selected().size() == before) break;
  }
  // What shows a single flat face has no pairs but flat ones. Larger faces come first.
  for (int round = 0; round < kMostFlatRounds && !sampled.empty(); ++round) {
    const std::size_t before = pool.selected().size();
    sample_round(kMostRounds + round, kFlatIterations, PairKind::kFlat, kFlatClusters);
    if (round > 0 && pool.selected().size() == before) break;
  }
  scene_.set_explained({});
  pool.slide_runners_up();
  pool.select(/*is_last=*/true);
  result_.counters.accepted = pool.accepted();
  result_.counters.verified = static_cast<int>(pool.candidates().size());
  pool.slide_selected();
  report_selected(pool);
  add_time("refine", watch.lap());
}

/// What is selected.
std::vector<Candidate> objects_of(const CandidatePool& pool) {
  std::vector<Candidate> objects;
  for (const SelectedCandidate& selected : pool.selected()) {
    objects.push_back(pool.candidates()[selected.candidate]);
  }
  return objects;
}

/// The poses of what is selected, refined and judged anew if that is wanted; those that then fit
/// better elsewhere, once more from there.
std::vector<RefinedPose> Run::final_poses(CandidatePool& pool) const {
  std::vector<RefinedPose> poses;
  if (!options_.refine) {
    for (const Candidate& object : objects_of(pool)) {
      poses.push_back({object.T_camera_model.cast<double>()});
    }
    return poses;
  }
  poses = refine_jointly(library_.models(), scene_, scene_.sensor(), pool.dilation(),
                         objects_of(pool), options_.jobs);
  pool.judge_refined(poses);
  const std::vector<int> moved = pool.move_elsewhere(poses);
  if (moved.empty()) return poses;
  refine_moved(library_.models(), scene_, scene_.sensor(), pool.dilation(), objects_of(pool), moved,
               poses, options_.jobs);
  pool.judge_refined(poses);
  return poses;
}

void Run::report_selected(CandidatePool& pool) {
  const std::vector<RefinedPose> refined = final_poses(pool);
  const std::vector<Candidate> objects = objects_of(pool);
  std::vector<double> displacements(objects.size());  // diameters
  std::vector<int> explained_points(objects.size());
  parallel_for(static_cast<int>(objects.size()), options_.jobs, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    const RecognitionModel& model =
        library_.models()[static_cast<std::size_t>(objects[index].model)];
    displacements[index] =
        most_uncertain_motion(model, refined[index].T_camera_model, refined[index].covariance)
            .displacement /
        static_cast<double>(model.diameter);
    explained_points[index] =
        static_cast<int>(leaves_of(scene_, pool.selected()[index].pixels).size());
  });
  if (options_.keep_considered) keep_considered(pool, refined, displacements);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const SelectedCandidate& selected = pool.selected()[i];
    if (pool.is_doubtful(selected, displacements[i])) continue;
    report(objects[i].model, refined[i].T_camera_model, explained_points[i]);
    result_.detections.back().covariance = refined[i].covariance;
    result_.detections.back().confidence = pool.detection_probability(selected, displacements[i]);
  }
  std::stable_sort(
      result_.detections.begin(), result_.detections.end(),
      [](const Detection& a, const Detection& b) { return a.confidence > b.confidence; });
}

void Run::keep_considered(const CandidatePool& pool, const std::vector<RefinedPose>& refined,
                          const std::vector<double>& displacements) {
  for (std::size_t i = 0; i < pool.candidates().size(); ++i) {
    const Candidate& candidate = pool.candidates()[i];
    ConsideredHypothesis considered;
    considered.model = library_.models()[static_cast<std::size_t>(candidate.model)].name;
    considered.T_camera_model = candidate.T_camera_model.cast<double>();
    considered.evidence = candidate.evidence;
    considered.features = pool.decided_features()[i];
    for (std::size_t s = 0; s < pool.selected().size(); ++s) {
      const SelectedCandidate& selected = pool.selected()[s];
      if (selected.candidate != i) continue;
      considered.T_camera_model = refined[s].T_camera_model;
      considered.features = acceptance_features(selected.evidence, pool.dilation());
      considered.margin = selected.margin;
      considered.displacement = displacements[s];
      considered.is_selected = true;
    }
    considered.T_scene_model = considered.T_camera_model;
    result_.considered.push_back(considered);
  }
}

/// The points of S* in whose leaves the transformed model has points.
std::vector<int> Run::explained_by(const Hypothesis& hypothesis) const {
  std::vector<int> leaves;
  for (const Eigen::Vector3f& p :
       library_.models()[static_cast<std::size_t>(hypothesis.model)].cover) {
    const int leaf = scene_.octree().leaf_at(hypothesis.T_camera_model * p);
    if (leaf >= 0 && !scene_.on_support(leaf)) leaves.push_back(leaf);
  }
  std::sort(leaves.begin(), leaves.end());
  leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
  return leaves;
}

void Run::report(int model, const Eigen::Isometry3d& T_camera_model, int explained_points) {
  const RecognitionModel& shape = library_.models()[static_cast<std::size_t>(model)];
  const float epsilon = tolerances_for(shape, scene_.noise()).fine;
  Detection detection;
  detection.model = shape.name;
  detection.T_scene_model = T_camera_model;
  const Acceptance terms =
      evaluate_acceptance(scene_, shape, detection.T_scene_model.cast<float>(), epsilon);
  detection.visibility = terms.visibility;
  detection.penalty = terms.penalty;
  detection.explained_points = explained_points;
  result_.detections.push_back(detection);
}

SupportPlane moved(const SupportPlane& plane, const Eigen::Isometry3d& T) {
  SupportPlane result = plane;
  result.normal = T.linear() * plane.normal;
  result.offset = plane.offset + result.normal.dot(T.translation());
  result.centre = T * plane.centre;
  result.axes = T.linear() * plane.axes;
  return result;
}

/// Why the models cannot be in the image for their size alone; empty when they can.
std::string size_mismatch(const RangeImage& image, const ModelLibrary& library) {
  constexpr double kFewestPointsAcross = 8.0;  // a model must be this many points wide
  constexpr double kSmallestExtent = 0.25;     // of a model's diameter
  const double spacing = point_spacing(image);
  if (!(spacing > 0.0)) return "the scene is empty";
  double diameter = library.models().front().diameter;
  for (const RecognitionModel& model : library.models()) {
    diameter = std::min(diameter, static_cast<double>(model.diameter));
  }
  if (kFewestPointsAcross * spacing > diameter) {
    return fmt::format(
        "scene points are {:.3g} m apart, too far for a model of {:.3g} m; check the units",
        spacing, diameter);
  }
  const double extent = spacing * std::max(image.intrinsics.width, image.intrinsics.height);
  if (extent < kSmallestExtent * diameter) {
    return fmt::format(
        "the scene is {:.3g} m wide, too small for a model of {:.3g} m; check the units", extent,
        diameter);
  }
  return {};
}

}  // namespace

Recognizer::Recognizer(std::shared_ptr<const ModelLibrary> library, RecognizerOptions options)
    : library_(std::move(library)), options_(options) {
  options_.validate();
  if (!library_ || library_->setting() != options_.setting) {
    throw InputError(
        "recognizer: its setting differs from the model library's; build the library "
        "with the same one");
  }
}

RecognitionResult Recognizer::recognize(const RangeImage& image, Seed seed) const {
  return recognize(image, Eigen::Isometry3d::Identity(), seed);
}

RecognitionResult Recognizer::recognize(const PointCloud& cloud, const Eigen::Vector3d& viewpoint,
                                        Seed seed) const {
  Stopwatch watch;
  const ProjectedCloud projected = project_cloud(cloud, viewpoint, options_.jobs);
  const double projection_seconds = watch.lap();
  RecognitionResult result = recognize(projected.image, projected.T_cloud_camera, seed);
  result.timings.insert(result.timings.begin(), {"projection", projection_seconds});
  result.total_seconds += projection_seconds;
  return result;
}

RecognitionResult Recognizer::recognize(const RangeImage& image,
                                        const Eigen::Isometry3d& T_scene_camera, Seed seed) const {
  const CameraIntrinsics& camera = image.intrinsics;
  if (camera.width < 0 || camera.height < 0 ||
      image.depth.size() !=
          static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) ||
      (!image.depth.empty() && !(camera.fx > 0.0 && camera.fy > 0.0))) {
    throw InputError(fmt::format(
        "range image: {} depths do not fit {} x {} pixels of focal lengths {} and {}; check the "
        "calibration",
        image.depth.size(), camera.width, camera.height, camera.fx, camera.fy));
  }
  Stopwatch watch;
  RecognitionResult unfit;
  unfit.note = size_mismatch(image, *library_);
  if (!unfit.note.empty()) return unfit;
  RecognitionResult result = Run(*library_, options_, image, seed).recognize();
  for (Detection& detection : result.detections) {
    detection.T_scene_model = T_scene_camera * detection.T_scene_model;
    Eigen::Matrix<double, 6, 6> R = Eigen::Matrix<double, 6, 6>::Zero();
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = T_scene_camera.linear();
    const Eigen::Matrix<double, 6, 6> turned = R * detection.covariance * R.transpose();
    detection.covariance = 0.5 * (turned + turned.transpose());  // symmetric to the last bit
  }
  for (ConsideredHypothesis& considered : result.considered) {
    considered.T_scene_model = T_scene_camera * considered.T_scene_model;
  }
  for (SupportPlane& plane : result.support_planes) plane = moved(plane, T_scene_camera);
  result.total_seconds = watch.lap();
  return result;
}

}  // namespace binpick
