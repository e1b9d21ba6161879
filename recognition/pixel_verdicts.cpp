#include "recognition/pixel_verdicts.h"

#include <algorithm>
#include <bit>

#include "recognition/eight_lanes.h"

namespace binpick {
namespace {

constexpr float kNearOcclusion = 6.0f;  // model tolerances: what is farther in front is an occluder
constexpr float kLikeNormal = 0.77f;    // 40 degrees

struct Normal {
  float x = 0.0f, y = 0.0f, z = 0.0f;
  bool is_smooth = false;  // so that the scene's normals mean something there
};

Normal normal_of(const VerdictRules& rules, std::int32_t triangle) {
  const auto index = static_cast<std::size_t>(triangle);
  const Eigen::Vector3f& n = rules.mesh->normals[index];
  const Eigen::Matrix3f& R = rules.R_camera_model;
  return {dot3(R(0, 0), R(0, 1), R(0, 2), n.x(), n.y(), n.z()),
          dot3(R(1, 0), R(1, 1), R(1, 2), n.x(), n.y(), n.z()),
          dot3(R(2, 0), R(2, 1), R(2, 2), n.x(), n.y(), n.z()),
          rules.mesh->roughness[index] < rules.roughest};
}

/// One pixel, and what it adds to the sums if it matches.
Verdict judge(const VerdictRules& rules, const Normal& n, float z, float n_ray,
              const ScenePixel& pixel, bool is_claimed, std::size_t part, VerdictSums& sums) {
  if (!(pixel.depth > 0.0f)) return Verdict::kMissing;
  const float in_front = n_ray * (pixel.depth - z);
  const float limit = rules.limit_squared(z, n_ray);
  const float square = in_front * in_front;
  const bool has_normal = (pixel.flags & ScenePixel::kNormal) != 0;
  if (square > limit) {
    if (in_front < 0.0f) return Verdict::kSeenThrough;
    const float reach = kNearOcclusion * rules.tolerance;
    const bool is_near = square < limit + reach * reach;
    return is_near && has_normal && !is_claimed ? Verdict::kNearOccluded : Verdict::kFarOccluded;
  }
  if (is_claimed) return Verdict::kClaimed;
  if ((pixel.flags & ScenePixel::kSupport) != 0) return Verdict::kOnSupport;
  if (n.is_smooth && has_normal) {
    const float cosine = dot3(n.x, n.y, n.z, kNormalUnit * static_cast<float>(pixel.nx),
                              kNormalUnit * static_cast<float>(pixel.ny),
                              kNormalUnit * static_cast<float>(pixel.nz));
    if (cosine < kLikeNormal) return Verdict::kBadNormal;
    sums.normal_error[part] += std::max(1.0f - cosine, 0.0f);  // stored normals are rounded
    ++sums.normals;
  }
  sums.residual[part] += in_front;
  sums.residual_squares[part] += square / limit;
  const std::array<float, 6> products = {n.x * n.x, n.x * n.y, n.x * n.z,
                                         n.y * n.y, n.y * n.z, n.z * n.z};
  for (std::size_t k = 0; k < products.size(); ++k) sums.scatter[k][part] += products[k];
  return Verdict::kMatched;
}

void judge_from(std::size_t begin, const PixelRow& row, const VerdictRules& rules,
                const VerdictRow& judged, VerdictSums& sums) {
  std::int32_t last_triangle = -1;
  Normal n;
  for (std::size_t i = begin; i < row.size; ++i) {
    const std::int32_t triangle = row.triangle[i];
    if (triangle < 0) continue;
    if (triangle != last_triangle) n = normal_of(rules, triangle);
    last_triangle = triangle;
    const std::int32_t owner = row.claims == nullptr ? -1 : row.claims[i];
    const float n_ray = dot3(n.x, n.y, n.z, row.ray_x[i], row.ray_y, 1.0f);
    const Verdict verdict =
        judge(rules, n, row.depth[i], n_ray, row.scene[i], owner >= 0 && owner != rules.claimant,
              i % VerdictSums::kParts, sums);
    judged.verdicts[i] = verdict;
    ++sums.counts[static_cast<std::size_t>(verdict)];
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    judged.covered[i / 64] |= bit;
    if (verdict == Verdict::kSeenThrough) judged.seen_through[i / 64] |= bit;
    if (verdict == Verdict::kNearOccluded) judged.near_occluded[i / 64] |= bit;
  }
}

void judge_row_portably(const PixelRow& row, const VerdictRules& rules, const VerdictRow& judged,
                        VerdictSums& sums) {
  judge_from(0, row, rules, judged, sums);
}

#if defined(__x86_64__)

struct Normals {
  __m256 x, y, z;
  __m256 is_smooth;
};

BINPICK_AVX2_INLINE Normals gather_normals(const VerdictRules& rules, __m256i triangles,
                                           __m256 inside) {
  const float* components = rules.mesh->normals.data()->data();  // three per triangle
  const __m256 zero = _mm256_setzero_ps();
  const __m256i first = _mm256_add_epi32(triangles, _mm256_add_epi32(triangles, triangles));  // 3 t
  const __m256 x = _mm256_mask_i32gather_ps(zero, components, first, inside, 4);
  const __m256 y = _mm256_mask_i32gather_ps(zero, components + 1, first, inside, 4);
  const __m256 z = _mm256_mask_i32gather_ps(zero, components + 2, first, inside, 4);
  const __m256 roughness =
      _mm256_mask_i32gather_ps(zero, rules.mesh->roughness.data(), triangles, inside, 4);
  const Eigen::Matrix3f& R = rules.R_camera_model;
  return {row_times(R, 0, x, y, z), row_times(R, 1, x, y, z), row_times(R, 2, x, y, z),
          _mm256_cmp_ps(roughness, _mm256_set1_ps(rules.roughest), _CMP_LT_OQ)};
}

/// VerdictRules::limit_squared of eight pixels.
BINPICK_AVX2_INLINE __m256 limit_squared(const VerdictRules& rules, __m256 z, __m256 n_ray) {
  const SensorEstimate& sensor = rules.sensor;
  const __m256 triangulation = _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(sensor.quadratic), z), z);
  const __m256 axial = _mm256_add_ps(_mm256_set1_ps(sensor.constant * sensor.constant),
                                     _mm256_mul_ps(triangulation, triangulation));
  const __m256 jitter = _mm256_mul_ps(_mm256_set1_ps(sensor.lateral * rules.pixel_width), z);
  const __m256 squared = _mm256_mul_ps(n_ray, n_ray);
  const __m256 slant =
      _mm256_max_ps(_mm256_sub_ps(_mm256_set1_ps(1.0f), squared), _mm256_setzero_ps());
  const __m256 variance = _mm256_add_ps(_mm256_mul_ps(squared, axial),
                                        _mm256_mul_ps(_mm256_mul_ps(jitter, jitter), slant));
  return _mm256_add_ps(_mm256_set1_ps(rules.tolerance * rules.tolerance),
                       _mm256_mul_ps(_mm256_set1_ps(9.0f), variance));
}

BINPICK_AVX2_INLINE unsigned lanes_like(__m256i values, std::int32_t value) {
  return bits_of(_mm256_castsi256_ps(_mm256_cmpeq_epi32(values, _mm256_set1_epi32(value))));
}

BINPICK_AVX2_INLINE void add_to(VerdictSums::Parts& parts, __m256 terms, __m256 mask) {
  _mm256_storeu_ps(parts.data(),
                   _mm256_add_ps(_mm256_loadu_ps(parts.data()), _mm256_and_ps(terms, mask)));
}

/// Undoes what shuffling within halves leaves of the order of pixels.
BINPICK_AVX2_INLINE __m256i in_order(__m256 mixed) {
  return _mm256_permute4x64_epi64(_mm256_castps_si256(mixed), 0xD8);
}

/// Eight verdicts, gathered from disjoint masks, and their counts.
class VerdictLanes {
 public:
  BINPICK_AVX2_INLINE explicit VerdictLanes(VerdictSums& sums) : sums_(sums) {}

  BINPICK_AVX2_INLINE unsigned set(Verdict verdict, __m256 mask) {
    const unsigned bits = bits_of(mask);
    sums_.counts[static_cast<std::size_t>(verdict)] += std::popcount(bits);
    const __m256i code = _mm256_set1_epi32(static_cast<int>(verdict));
    codes_ = _mm256_or_si256(codes_, _mm256_and_si256(_mm256_castps_si256(mask), code));
    return bits;
  }
  BINPICK_AVX2_INLINE void store(Verdict* verdicts) const {
    const __m128i words =
        _mm_packs_epi32(_mm256_castsi256_si128(codes_), _mm256_extracti128_si256(codes_, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(verdicts), _mm_packus_epi16(words, words));
  }

 private:
  VerdictSums& sums_;
  __m256i codes_ = _mm256_setzero_si256();
};

BINPICK_AVX2 void judge_row_avx2(const PixelRow& row, const VerdictRules& rules,
                                 const VerdictRow& judged, VerdictSums& sums) {
  constexpr std::size_t kLanes = VerdictSums::kParts;
  const __m256 zero = _mm256_setzero_ps();
  constexpr std::int32_t kNone = -1;
  std::int32_t last_triangle = kNone;  // in all lanes
  Normals n = {zero, zero, zero, zero};
  std::size_t i = 0;
  for (; i + kLanes <= row.size; i += kLanes) {
    const __m256i triangles =
        _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row.triangle + i));
    const __m256 inside = _mm256_castsi256_ps(_mm256_cmpgt_epi32(triangles, _mm256_set1_epi32(-1)));
    const unsigned covered = bits_of(inside);
    if (covered == 0) continue;
    // Most rows cross large triangles.
    const std::int32_t first = row.triangle[i];
    const bool is_one = lanes_like(triangles, first) == 0xffu;
    if (!is_one || first != last_triangle) n = gather_normals(rules, triangles, inside);
    last_triangle = is_one ? first : kNone;

    // Four pixels of depth and packed normal each: depths and normals side by side.
    const auto* scene = reinterpret_cast<const float*>(row.scene + i);
    const __m256 low = _mm256_loadu_ps(scene);
    const __m256 high = _mm256_loadu_ps(scene + kLanes);
    const __m256 depth = _mm256_castsi256_ps(in_order(_mm256_shuffle_ps(low, high, 0x88)));
    const __m256i packed = in_order(_mm256_shuffle_ps(low, high, 0xDD));
    const __m256 measured = _mm256_and_ps(inside, _mm256_cmp_ps(depth, zero, _CMP_GT_OQ));

    __m256 claimed = zero;
    if (row.claims != nullptr) {
      const __m256i owners = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row.claims + i));
      claimed = _mm256_castsi256_ps(
          _mm256_andnot_si256(_mm256_cmpeq_epi32(owners, _mm256_set1_epi32(rules.claimant)),
                              _mm256_cmpgt_epi32(owners, _mm256_set1_epi32(-1))));
    }

    const __m256 z = _mm256_loadu_ps(row.depth + i);
    const __m256 n_ray = dot3(n.x, n.y, n.z, _mm256_loadu_ps(row.ray_x + i),
                              _mm256_set1_ps(row.ray_y), _mm256_set1_ps(1.0f));
    const __m256 in_front = _mm256_mul_ps(n_ray, _mm256_sub_ps(depth, z));
    const __m256 limit = limit_squared(rules, z, n_ray);
    const __m256 square = _mm256_mul_ps(in_front, in_front);
    const __m256 has_normal = has_flag(packed, ScenePixel::kNormal);

    const __m256 differs = _mm256_and_ps(measured, _mm256_cmp_ps(square, limit, _CMP_GT_OQ));
    const __m256 behind = _mm256_and_ps(differs, _mm256_cmp_ps(in_front, zero, _CMP_LT_OQ));
    const float reach = kNearOcclusion * rules.tolerance;
    const __m256 in_reach =
        _mm256_cmp_ps(square, _mm256_add_ps(limit, _mm256_set1_ps(reach * reach)), _CMP_LT_OQ);
    const __m256 before = _mm256_andnot_ps(behind, differs);
    const __m256 near =
        _mm256_andnot_ps(claimed, _mm256_and_ps(before, _mm256_and_ps(in_reach, has_normal)));
    const __m256 agrees = _mm256_andnot_ps(differs, measured);
    const __m256 own = _mm256_andnot_ps(claimed, agrees);
    const __m256 on_support = _mm256_and_ps(own, has_flag(packed, ScenePixel::kSupport));
    const __m256 free = _mm256_andnot_ps(on_support, own);
    const __m256 compared = _mm256_and_ps(free, _mm256_and_ps(n.is_smooth, has_normal));
    const __m256 cosine = dot3(n.x, n.y, n.z, normal_component<0>(packed),
                               normal_component<1>(packed), normal_component<2>(packed));
    const __m256 bad_normal =
        _mm256_and_ps(compared, _mm256_cmp_ps(cosine, _mm256_set1_ps(kLikeNormal), _CMP_LT_OQ));
    const __m256 alike = _mm256_andnot_ps(bad_normal, compared);
    const __m256 matched = _mm256_andnot_ps(bad_normal, free);

    VerdictLanes lanes(sums);
    lanes.set(Verdict::kMissing, _mm256_andnot_ps(measured, inside));
    const std::uint64_t seen_through = lanes.set(Verdict::kSeenThrough, behind);
    const std::uint64_t near_occluded = lanes.set(Verdict::kNearOccluded, near);
    lanes.set(Verdict::kFarOccluded, _mm256_andnot_ps(near, before));
    lanes.set(Verdict::kClaimed, _mm256_and_ps(claimed, agrees));
    lanes.set(Verdict::kOnSupport, on_support);
    lanes.set(Verdict::kBadNormal, bad_normal);
    lanes.set(Verdict::kMatched, matched);
    lanes.store(judged.verdicts + i);
    const std::size_t shift = i % 64;
    judged.covered[i / 64] |= std::uint64_t{covered} << shift;
    judged.seen_through[i / 64] |= seen_through << shift;
    judged.near_occluded[i / 64] |= near_occluded << shift;

    sums.normals += std::popcount(bits_of(alike));
    add_to(sums.normal_error, _mm256_max_ps(_mm256_sub_ps(_mm256_set1_ps(1.0f), cosine), zero),
           alike);
    add_to(sums.residual, in_front, matched);
    add_to(sums.residual_squares, _mm256_div_ps(square, limit), matched);
    add_to(sums.scatter[0], _mm256_mul_ps(n.x, n.x), matched);
    add_to(sums.scatter[1], _mm256_mul_ps(n.x, n.y), matched);
    add_to(sums.scatter[2], _mm256_mul_ps(n.x, n.z), matched);
    add_to(sums.scatter[3], _mm256_mul_ps(n.y, n.y), matched);
    add_to(sums.scatter[4], _mm256_mul_ps(n.y, n.z), matched);
    add_to(sums.scatter[5], _mm256_mul_ps(n.z, n.z), matched);
  }
  // Left out by gcc 12; without it all scalar code that follows runs slowly.
  _mm256_zeroupper();
  judge_from(i, row, rules, judged, sums);
}

#endif

}  // namespace

Eigen::Matrix3f VerdictSums::normal_scatter() const {
  Eigen::Matrix3f sum;
  std::size_t k = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = r; c < 3; ++c) sum(r, c) = sum(c, r) = total(scatter[k++]);
  }
  return sum;
}

JudgeRow portable_judge_row() noexcept { return judge_row_portably; }

JudgeRow best_judge_row() noexcept {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt")) return judge_row_avx2;
#endif
  return portable_judge_row();
}

}  // namespace binpick
