#include "recognition/hypothesis_evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace binpick {
namespace {

constexpr float kContinuedNormal = 0.94f;  // 20 degrees
constexpr int kRimWidth = 2;
constexpr int kInwardReach = 3;
constexpr int kLeastOutwardReach = 5;   // pixels: beyond any sensor's dilation
constexpr float kLeavesOutward = 1.6f;  // and this many leaves beyond the silhouette
constexpr float kSteepest = 5.0f;       // tangent of the slant at which a surface may go on
constexpr float kNoise = 3.0f;          // standard deviations
constexpr float kContinuedBand = 1.5f;  // limits
constexpr float kStepBand = 3.0f;       // limits
constexpr float kSmoothStep = 0.6f;     // 53 degrees between neighbours: normals are noisy
constexpr float kSmoothTurn = 0.7f;     // 46 degrees in all: less than at most creases
constexpr int kBeyond = 3;              // pixels outside the silhouette
// A normal counts where those within this many leaves of it, the reach of the scene's normals, have
// a mean not much shorter than 1: a cap of 45 degrees has 0.85.
constexpr float kNormalReach = 1.5f;
constexpr float kRoughest = 0.15f;
// A step of depth places the silhouette to about two pixels, a matched pixel the surface to less
// than one; every other pixel of the silhouette is walked.
constexpr float kStepInformation = 0.5f;

constexpr float square(float x) { return x * x; }

/// How far a silhouette is walked outwards from a pixel of the model `pixel` metres wide.
int outward_reach(const ObservedScene& scene, float pixel) {
  return std::max(
      kLeastOutwardReach,
      static_cast<int>(std::lround(kLeavesOutward * scene.octree().leaf_size() / pixel)));
}

}  // namespace

/// One comparison: the pixels of the rendered model are judged in one sweep, then the silhouette.
class EvidencePass {
 public:
  EvidencePass(EvidenceGatherer& gatherer, const RecognitionModel& model,
               const Eigen::Isometry3f& T_camera_model, const RenderedModel& rendered,
               const PixelClaims* claims, std::int32_t claimant)
      : gatherer_(gatherer),
        scene_(gatherer.scene_),
        projection_(gatherer.scene_.projection()),
        model_(model),
        rules_(rules(gatherer, model, T_camera_model, claimant)),
        claims_(claims),
        window_(rendered),
        covered_(gatherer.covered_) {
    gatherer.rendered_ = &window_;
    gatherer.model_ = &model;
    gatherer.R_camera_model_ = rules_.R_camera_model;
    gatherer.steps_.clear();
  }

  HypothesisEvidence run() {
    judge_pixels();
    walk_silhouette();
    finish();
    return evidence_;
  }

 private:
  [[nodiscard]] static VerdictRules rules(const EvidenceGatherer& gatherer,
                                          const RecognitionModel& model,
                                          const Eigen::Isometry3f& T_camera_model,
                                          std::int32_t claimant) {
    VerdictRules rules;
    rules.R_camera_model = T_camera_model.linear();
    rules.mesh = &model.render_mesh;
    rules.roughest = kRoughest / square(kNormalReach * gatherer.scene_.octree().leaf_size());
    rules.tolerance = model_tolerance(model);
    rules.sensor = gatherer.sensor_;
    rules.pixel_width = 1.0f / gatherer.scene_.projection().fx;
    rules.claimant = claimant;
    return rules;
  }
  [[nodiscard]] int scene_index(int u, int v) const {
    return (window_.v0 + v) * projection_.width + window_.u0 + u;
  }
  [[nodiscard]] bool is_claimed(int index) const {
    if (claims_ == nullptr) return false;
    const std::int32_t owner = (*claims_)[static_cast<std::size_t>(index)];
    return owner >= 0 && owner != rules_.claimant;
  }
  [[nodiscard]] Eigen::Vector3f normal_of(std::int32_t triangle) const {
    return rules_.R_camera_model * model_.render_mesh.normals[static_cast<std::size_t>(triangle)];
  }

  void judge_pixels() {
    std::vector<float>& ray_x = gatherer_.ray_x_;
    ray_x.resize(static_cast<std::size_t>(window_.width));
    for (int u = 0; u < window_.width; ++u) {
      ray_x[static_cast<std::size_t>(u)] =
          (static_cast<float>(window_.u0 + u) - projection_.cx) / projection_.fx;
    }
    gatherer_.verdicts_.assign(window_.depth.size(), Verdict::kOutside);
    for (CoverageMask* mask : {&covered_, &gatherer_.seen_through_, &gatherer_.near_occluded_}) {
      mask->reset(window_.width, window_.height);
    }
    static const JudgeRow judge_row = best_judge_row();
    PixelRow row;
    row.size = static_cast<std::size_t>(window_.width);
    row.ray_x = ray_x.data();
    for (int v = 0; v < window_.height; ++v) {
      const std::size_t first = window_.index(0, v);
      const auto first_of_scene = static_cast<std::size_t>(scene_index(0, v));
      row.depth = window_.depth.data() + first;
      row.triangle = window_.triangle.data() + first;
      row.scene = scene_.pixels().data() + first_of_scene;
      row.claims = claims_ == nullptr ? nullptr : claims_->data() + first_of_scene;
      row.ray_y = (static_cast<float>(window_.v0 + v) - projection_.cy) / projection_.fy;
      judge_row(row, rules_,
                {gatherer_.verdicts_.data() + first, covered_.row(v),
                 gatherer_.seen_through_.row(v), gatherer_.near_occluded_.row(v)},
                sums_);
    }
    count();
  }

  void count() {
    evidence_.matched = sums_.count(Verdict::kMatched);
    evidence_.bad_normal = sums_.count(Verdict::kBadNormal);
    evidence_.far_occluded = sums_.count(Verdict::kFarOccluded);
    evidence_.missing = sums_.count(Verdict::kMissing);
    evidence_.on_support = sums_.count(Verdict::kOnSupport);
    evidence_.claimed = sums_.count(Verdict::kClaimed);
    for (const int count : sums_.counts) evidence_.rendered += count;
    for (int v = 0; v < window_.height; ++v) {
      for (int word = 0; word < covered_.words(); ++word) {
        const std::uint64_t seen_through = gatherer_.seen_through_.row(v)[word];
        const std::uint64_t near_occluded = gatherer_.near_occluded_.row(v)[word];
        if ((seen_through | near_occluded) == 0) continue;
        std::uint64_t inner = ~std::uint64_t{0};
        for (int step = 1; step <= kRimWidth; ++step) {
          inner &= covered_.neighbours(word, v, step).all();
        }
        evidence_.seen_through += std::popcount(seen_through & inner);
        evidence_.seen_through_rim += std::popcount(seen_through & ~inner);
        evidence_.near_occluded += std::popcount(near_occluded & inner);
        evidence_.far_occluded += std::popcount(near_occluded & ~inner);
      }
    }
  }

  [[nodiscard]] Verdict verdict_at(int u, int v) const {
    if (u < 0 || v < 0 || u >= window_.width || v >= window_.height) return Verdict::kOutside;
    return gatherer_.verdicts_[window_.index(u, v)];
  }
  /// Every other pixel of the silhouette.
  void walk_silhouette() {
    constexpr std::uint64_t kEven = 0x5555555555555555u;
    for (int v = 0; v < window_.height; ++v) {
      const std::uint64_t every_other = v % 2 == 0 ? kEven : ~kEven;
      for (int word = 0; word < covered_.words(); ++word) {
        const std::uint64_t here = covered_.row(v)[word] & every_other;
        if (here == 0) continue;
        const CoverageMask::Neighbours beside = covered_.neighbours(word, v, 1);
        for_each_pixel(here & ~beside.all(), word, [&](int u) {
          const std::uint64_t bit = std::uint64_t{1} << (u % 64);
          if ((beside.left & bit) == 0) walk(u, v, -1, 0);
          if ((beside.right & bit) == 0) walk(u, v, 1, 0);
          if ((beside.above & bit) == 0) walk(u, v, 0, -1);
          if ((beside.below & bit) == 0) walk(u, v, 0, 1);
        });
      }
    }
  }

  void add_edge(int u, int v, int du, int dv, int offset) {
    ++evidence_.edges_matched;
    offset_sum_ += static_cast<float>(offset);
    offset_squares_ += static_cast<float>(offset * offset);
    const Eigen::Vector2f across = outwards(u, v);
    edge_scatter_.noalias() += across * across.transpose();
    gatherer_.steps_.push_back({window_.u0 + u, window_.v0 + v, du, dv, offset,
                                window_.depth[window_.index(u, v)], across});
  }

  /// The direction in which the covered part of the neighbourhood thins out.
  [[nodiscard]] Eigen::Vector2f outwards(int u, int v) const {
    constexpr int kReach = 3;
    int sum_u = 0;
    int sum_v = 0;
    for (int dv = -kReach; dv <= kReach; ++dv) {
      const unsigned row = covered_.seven_about(u, v + dv);
      sum_v += dv * std::popcount(row);
      for (int du = 1; du <= kReach; ++du) {
        sum_u += du * (static_cast<int>(row >> (kReach + du) & 1u) -
                       static_cast<int>(row >> (kReach - du) & 1u));
      }
    }
    return -Eigen::Vector2f(static_cast<float>(sum_u), static_cast<float>(sum_v)).normalized();
  }

  /// From a pixel of the silhouette: where does the scene step back?
  void walk(int u, int v, int du, int dv) {
    const Verdict verdict = verdict_at(u, v);
    ++evidence_.edges;
    if (verdict == Verdict::kSeenThrough) {
      ++evidence_.edges_seen;
      walk_inwards(u, v, du, dv);
    } else if (verdict == Verdict::kMatched || verdict == Verdict::kBadNormal) {
      ++evidence_.edges_seen;
      walk_outwards(u, v, du, dv);
    } else if (verdict == Verdict::kNearOccluded || verdict == Verdict::kFarOccluded) {
      walk_through(u, v, du, dv);
    }
  }

  /// From one pixel of the scene to its neighbour: is it the same smooth surface, nobody else's?
  [[nodiscard]] bool goes_on(int u, int v, int du, int dv, float steepest) const {
    const int to_u = u + du;
    const int to_v = v + dv;
    if (to_u < 0 || to_v < 0 || to_u >= projection_.width || to_v >= projection_.height) {
      return false;
    }
    const int index = to_v * projection_.width + to_u;
    const ScenePixel& from = scene_.pixel(v * projection_.width + u);
    const ScenePixel& to = scene_.pixel(index);
    return to.depth > 0.0f && (to.flags & ScenePixel::kSupport) == 0 && !is_claimed(index) &&
           std::abs(to.depth - from.depth) < steepest &&
           from.normal().dot(to.normal()) > kSmoothStep;
  }

  /// From a pixel of the silhouette that something in front hides, or beside which something is in
  /// front. An occluder or a neighbour has an edge of its own; a surface that goes smoothly on from
  /// where it matches, then in front of the model, to beyond the silhouette is that of something
  /// larger.
  void walk_through(int u, int v, int du, int dv) {
    const float z = window_.depth[window_.index(u, v)];
    const float steepest = std::sqrt(square(kSteepest * rules_.pixel_width * z) +
                                     square(kNoise) * 2.0f * rules_.sensor.axial_variance(z));
    const auto goes_on_from = [&](int k, int direction) {
      return goes_on(window_.u0 + u + k * du, window_.v0 + v + k * dv, direction * du,
                     direction * dv, steepest);
    };
    int k = 0;
    for (Verdict verdict = verdict_at(u, v);
         verdict != Verdict::kMatched && verdict != Verdict::kBadNormal;
         verdict = verdict_at(u + k * du, v + k * dv)) {
      const bool is_in_front =
          verdict == Verdict::kNearOccluded || verdict == Verdict::kFarOccluded;
      if (!is_in_front || !goes_on_from(k, -1)) return;
      --k;
    }
    const ScenePixel& matched = scene_.pixel(scene_index(u + k * du, v + k * dv));
    for (k = 0; k < kBeyond; ++k) {
      const bool is_notch = verdict_at(u + (k + 1) * du, v + (k + 1) * dv) != Verdict::kOutside;
      if (is_notch || !goes_on_from(k, 1)) return;
    }
    const ScenePixel& beyond = scene_.pixel(scene_index(u + k * du, v + k * dv));
    if (matched.normal().dot(beyond.normal()) > kSmoothTurn) ++evidence_.edges_continued;
  }

  void walk_inwards(int u, int v, int du, int dv) {
    for (int k = 1; k <= kInwardReach; ++k) {
      const Verdict inside = verdict_at(u - k * du, v - k * dv);
      if (inside == Verdict::kMatched || inside == Verdict::kBadNormal) {
        return add_edge(u, v, du, dv, -k);
      }
      if (inside != Verdict::kSeenThrough) return;
    }
    ++evidence_.edges_missed;
  }

  void walk_outwards(int u, int v, int du, int dv) {
    const std::size_t start = window_.index(u, v);
    const float z = window_.depth[start];
    const Eigen::Vector3f n = normal_of(window_.triangle[start]);
    const Eigen::Vector3f p = projection_.point(window_.u0 + u, window_.v0 + v, z);
    const float height = n.dot(p);
    const float pixel = rules_.pixel_width * z;
    const int reach = outward_reach(scene_, pixel);
    bool reliable = false;
    bool alike = false;
    for (int k = 1; k <= reach; ++k) {
      const int at_u = window_.u0 + u + k * du;
      const int at_v = window_.v0 + v + k * dv;
      if (at_u < 0 || at_v < 0 || at_u >= projection_.width || at_v >= projection_.height) return;
      // A notch of the silhouette says nothing.
      if (verdict_at(u + k * du, v + k * dv) != Verdict::kOutside) return;
      const int index = at_v * projection_.width + at_u;
      const ScenePixel& seen = scene_.pixel(index);
      if (!(seen.depth > 0.0f)) {
        ++evidence_.edges_open;
        return;
      }
      // Where the model's tangent plane would be, and how far from it in depth it is still there.
      const float n_ray = n.dot(projection_.point(at_u, at_v, 1.0f));
      const float farthest = kSteepest * pixel * static_cast<float>(k);
      const float plane = n_ray < -0.05f ? height / n_ray : z + farthest;
      const float behind = seen.depth - std::clamp(plane, z - farthest, z + farthest);
      const float limit = std::sqrt(rules_.limit_squared(z, n_ray)) / std::max(-n_ray, 0.3f);
      if (behind > kStepBand * limit) return add_edge(u, v, du, dv, k - 1);
      if (behind < -kContinuedBand * limit) return walk_through(u, v, du, dv);
      if ((seen.flags & ScenePixel::kSupport) != 0 || is_claimed(index)) return;
      reliable = (seen.flags & ScenePixel::kNormal) != 0;
      alike =
          reliable && n.dot(seen.normal()) > kContinuedNormal && behind < kContinuedBand * limit;
    }
    if (alike) ++evidence_.edges_continued;
  }

  void finish() {
    if (evidence_.matched > 0) {
      const auto matched = static_cast<float>(evidence_.matched);
      evidence_.residual_mean = VerdictSums::total(sums_.residual) / (matched * rules_.tolerance);
      evidence_.residual_rms = std::sqrt(VerdictSums::total(sums_.residual_squares) / matched);
      const Eigen::Matrix3f scatter = sums_.normal_scatter();
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
      solver.computeDirect(scatter / matched, Eigen::EigenvaluesOnly);
      evidence_.second_face = std::max(solver.eigenvalues()[1], 0.0f);
      Eigen::Matrix3f information = scatter;
      information.topLeftCorner<2, 2>() += kStepInformation * edge_scatter_;
      solver.computeDirect(information, Eigen::EigenvaluesOnly);
      evidence_.least_information = std::max(solver.eigenvalues()[0], 0.0f);
    }
    if (sums_.normals > 0) {
      evidence_.normal_error =
          VerdictSums::total(sums_.normal_error) / static_cast<float>(sums_.normals);
    }
    if (evidence_.edges_matched > 0) {
      const auto edges = static_cast<float>(evidence_.edges_matched);
      evidence_.edge_offset = offset_sum_ / edges;
      evidence_.edge_spread = std::sqrt(
          std::max(offset_squares_ / edges - evidence_.edge_offset * evidence_.edge_offset, 0.0f));
    }
  }

  EvidenceGatherer& gatherer_;
  const ObservedScene& scene_;
  const Projection& projection_;
  const RecognitionModel& model_;
  const VerdictRules rules_;
  const PixelClaims* claims_;
  const RenderedModel& window_;

  CoverageMask& covered_;
  VerdictSums sums_;
  Eigen::Matrix2f edge_scatter_ = Eigen::Matrix2f::Zero();
  float offset_sum_ = 0.0f;
  float offset_squares_ = 0.0f;
  HypothesisEvidence evidence_;
};

HypothesisEvidence EvidenceGatherer::gather(const RecognitionModel& model,
                                            const Eigen::Isometry3f& T_camera_model,
                                            const PixelClaims* claims, std::int32_t claimant) {
  return gather_again(model, T_camera_model, render(model, T_camera_model), claims, claimant);
}

const RenderedModel& EvidenceGatherer::render(const RecognitionModel& model,
                                              const Eigen::Isometry3f& T_camera_model) {
  rendered_ = &rasterizer_.render(model.render_mesh, T_camera_model, scene_.projection());
  return *rendered_;
}

HypothesisEvidence EvidenceGatherer::gather_again(const RecognitionModel& model,
                                                  const Eigen::Isometry3f& T_camera_model,
                                                  const RenderedModel& rendered,
                                                  const PixelClaims* claims,
                                                  std::int32_t claimant) {
  HypothesisEvidence evidence =
      EvidencePass(*this, model, T_camera_model, rendered, claims, claimant).run();
  // A convex body's shadow is a quarter of its surface on average (Cauchy).
  const Projection& projection = scene_.projection();
  const float z = std::max((T_camera_model * model.centre).z(), 1e-3f);
  evidence.expected = 0.25f * model.area * projection.fx * projection.fy / (z * z);
  return evidence;
}

PixelBox EvidenceGatherer::reached() const {
  if (rendered_ == nullptr || rendered_->depth.empty()) return {};
  const int reach = outward_reach(scene_, rendered_->nearest / scene_.projection().fx);
  return {rendered_->u0 - reach, rendered_->v0 - reach, rendered_->u0 + rendered_->width + reach,
          rendered_->v0 + rendered_->height + reach};
}

void EvidenceGatherer::explained_pixels(std::vector<int>& pixels) const {
  pixels.clear();
  if (rendered_ == nullptr) return;
  std::size_t i = 0;
  for (int v = 0; v < rendered_->height; ++v) {
    for (int u = 0; u < rendered_->width; ++u, ++i) {
      if (verdicts_[i] != Verdict::kMatched && verdicts_[i] != Verdict::kBadNormal) continue;
      pixels.push_back((rendered_->v0 + v) * scene_.projection().width + rendered_->u0 + u);
    }
  }
}

int EvidenceGatherer::matched_count(const PixelClaims& claims, std::int32_t claimant) const {
  if (rendered_ == nullptr) return 0;
  int count = 0;
  std::size_t i = 0;
  for (int v = 0; v < rendered_->height; ++v) {
    const std::int32_t* row = claims.data() +
                              std::ptrdiff_t{rendered_->v0 + v} * scene_.projection().width +
                              rendered_->u0;
    for (int u = 0; u < rendered_->width; ++u, ++i) {
      if (verdicts_[i] == Verdict::kMatched && (row[u] < 0 || row[u] == claimant)) ++count;
    }
  }
  return count;
}

void EvidenceGatherer::matched_pixels(int stride, std::vector<MatchedPixel>& pixels) const {
  pixels.clear();
  if (rendered_ == nullptr) return;
  const Projection& projection = scene_.projection();
  for (int v = stride / 2; v < rendered_->height; v += stride) {
    for (int u = stride / 2; u < rendered_->width; u += stride) {
      const std::size_t i = rendered_->index(u, v);
      if (verdicts_[i] != Verdict::kMatched) continue;
      const Eigen::Vector3f ray = projection.point(rendered_->u0 + u, rendered_->v0 + v, 1.0f);
      const auto triangle = static_cast<std::size_t>(rendered_->triangle[i]);
      const Eigen::Vector3f normal = R_camera_model_ * model_->render_mesh.normals[triangle];
      const float z = rendered_->depth[i];
      const int index = (rendered_->v0 + v) * projection.width + rendered_->u0 + u;
      pixels.push_back({z * ray, normal, scene_.pixel(index).depth * ray,
                        sensor_.normal_variance(z, normal.dot(ray), 1.0f / projection.fx)});
    }
  }
}

}  // namespace binpick
