#include "recognition/table_hit_rate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "models/random.h"

namespace binpick {
namespace {

constexpr double kNormalNoise = 0.1;
constexpr double kLeastHitRate = 0.05;
constexpr std::array<float, 4> kPointsPerDiameter = {21.0f, 25.0f, 29.0f, 33.0f};
constexpr int kPairs = 1000;
constexpr int kDrawsPerPair = 64;   // to find a second point in the shell
constexpr float kNearPose = 0.08f;  // of the diameter: what alignment brings home

OrientedPoint draw_point(const RecognitionModel& model, Random& random) {
  const auto i = static_cast<std::size_t>(random.index(model.cover.size()));
  return {model.cover[i], model.cover_normals[i]};
}

/// The point with the normal that a scan would show.
OrientedPoint measured(const OrientedPoint& point, double normal_noise, Random& random) {
  const Eigen::Vector3f a = point.n.unitOrthogonal();
  const Eigen::Vector3f b = point.n.cross(a);
  const auto turn_a = static_cast<float>(normal_noise * random.normal());
  const auto turn_b = static_cast<float>(normal_noise * random.normal());
  return {point.p, (point.n + turn_a * a + turn_b * b).normalized()};
}

/// Whether a pose leaves the model near its place, or where a symmetry puts it.
class NearIdentity {
 public:
  explicit NearIdentity(const RecognitionModel& model)
      : model_(model), limit_(kNearPose * model.diameter) {}

  [[nodiscard]] bool operator()(const Eigen::Isometry3f& T) const {
    return std::any_of(
        model_.symmetries.begin(), model_.symmetries.end(), [&](const Eigen::Isometry3d& S) {
          const Eigen::Isometry3f symmetry = S.cast<float>();
          return std::all_of(model_.hull.begin(), model_.hull.end(), [&](const auto& p) {
            return (T * p - symmetry * p).squaredNorm() < limit_ * limit_;
          });
        });
  }

 private:
  const RecognitionModel& model_;
  float limit_;
};

}  // namespace

double table_hit_rate(const RecognitionModel& model, const PairTableOptions& options,
                      double normal_noise) {
  const PairTable table({model}, options);
  const NearIdentity is_near(model);
  Random random(derive_seed(Seed{0}, "table hit rate"));
  int drawn = 0;
  int hits = 0;
  for (int i = 0; i < kPairs; ++i) {
    const OrientedPoint on_u = draw_point(model, random);
    std::optional<OrientedPoint> on_v;
    for (int draw = 0; draw < kDrawsPerPair && !on_v; ++draw) {
      const OrientedPoint candidate = draw_point(model, random);
      if (std::abs((candidate.p - on_u.p).norm() - options.width) < options.tolerance) {
        on_v = candidate;
      }
    }
    if (!on_v) continue;
    const OrientedPoint u = measured(on_u, normal_noise, random);
    const OrientedPoint v = measured(*on_v, normal_noise, random);
    const PairDescriptor f = pair_descriptor(u, v);
    if (options.drop_coplanar && is_coplanar(f)) continue;
    const auto F_wx = pair_frame(u, v);
    if (!F_wx) continue;
    ++drawn;
    const auto stored = table.pairs(PairTable::cell(f), 0);
    hits += std::any_of(stored.begin(), stored.end(), [&](const PairFrame& F_uv_inverse) {
      return is_near(hypothesis_pose(*F_wx, F_uv_inverse));
    });
  }
  return drawn > 0 ? static_cast<double>(hits) / drawn : 0.0;
}

void densify_pair_points(RecognitionModel& model, const PairTableOptions& options) {
  for (const float points_per_diameter : kPointsPerDiameter) {
    if (table_hit_rate(model, options, kNormalNoise) >= kLeastHitRate) return;
    set_pair_points(model, points_per_diameter);
  }
}

}  // namespace binpick
