#include "recognition/point_kernels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "recognition/eight_lanes.h"

namespace binpick {
namespace {

constexpr std::size_t kLanes = 8;

constexpr float kLikeNormal = 0.8f;     // 37 degrees: normals of edges and corners are smeared
constexpr float kGrazingCosine = 0.1f;  // points turned further away are not expected to be seen
constexpr float kAlignedNormal = 0.7f;  // 46 degrees: a pose to be aligned is still turned

/// Pose and camera as the loops read them.
struct View {
  View(const ObservedScene& observed, const Eigen::Isometry3f& T_camera_model)
      : R(T_camera_model.linear()),
        t(T_camera_model.translation()),
        camera(observed.projection()),
        pixels(observed.searched_pixels().data()),
        inverse_fx(1.0f / camera.fx),
        inverse_fy(1.0f / camera.fy) {}

  Eigen::Matrix3f R;
  Eigen::Vector3f t;
  Projection camera;
  const ScenePixel* pixels;
  float inverse_fx;
  float inverse_fy;
};

/// A model point and what the sensor sees in its direction.
struct Sight {
  float px, py, pz;  // the point, camera frame
  float nx, ny, nz;
  bool faces = false;     // the sensor, within the image
  bool measured = false;  // faces, and something was measured there
  float residual = 0.0f;  // the measured point's distance along the model's normal
  float cosine = 0.0f;    // between the normals
  std::uint8_t flags = 0;
};

Sight look(const View& view, const TestPoints& points, std::size_t i, float grazing_cosine) {
  const Eigen::Matrix3f& R = view.R;
  const float x = points.x[i], y = points.y[i], z = points.z[i];
  const float nx = points.nx[i], ny = points.ny[i], nz = points.nz[i];
  Sight s;
  s.px = dot3(R(0, 0), R(0, 1), R(0, 2), x, y, z) + view.t.x();
  s.py = dot3(R(1, 0), R(1, 1), R(1, 2), x, y, z) + view.t.y();
  s.pz = dot3(R(2, 0), R(2, 1), R(2, 2), x, y, z) + view.t.z();
  s.nx = dot3(R(0, 0), R(0, 1), R(0, 2), nx, ny, nz);
  s.ny = dot3(R(1, 0), R(1, 1), R(1, 2), nx, ny, nz);
  s.nz = dot3(R(2, 0), R(2, 1), R(2, 2), nx, ny, nz);
  const float away = dot3(s.nx, s.ny, s.nz, s.px, s.py, s.pz);
  const float squared = dot3(s.px, s.py, s.pz, s.px, s.py, s.pz);
  if (!(away < 0.0f) || !(away * away >= grazing_cosine * grazing_cosine * squared)) return s;
  const Projection& camera = view.camera;
  if (!(s.pz > 0.0f)) return s;
  const float inverse = 1.0f / s.pz;
  const float u = camera.fx * s.px * inverse + camera.cx + 0.5f;
  const float v = camera.fy * s.py * inverse + camera.cy + 0.5f;
  if (!(u >= 0.0f && v >= 0.0f && u < static_cast<float>(camera.width) &&
        v < static_cast<float>(camera.height))) {
    return s;
  }
  s.faces = true;
  const int column = static_cast<int>(u);
  const int row = static_cast<int>(v);
  const ScenePixel& pixel = view.pixels[row * camera.width + column];
  s.measured = pixel.depth > 0.0f;
  const float qx = (static_cast<float>(column) - camera.cx) * view.inverse_fx * pixel.depth;
  const float qy = (static_cast<float>(row) - camera.cy) * view.inverse_fy * pixel.depth;
  s.residual = dot3(s.nx, s.ny, s.nz, qx - s.px, qy - s.py, pixel.depth - s.pz);
  s.cosine =
      dot3(s.nx, s.ny, s.nz, kNormalUnit * static_cast<float>(pixel.nx),
           kNormalUnit * static_cast<float>(pixel.ny), kNormalUnit * static_cast<float>(pixel.nz));
  s.flags = pixel.flags;
  return s;
}

void count_points(const View& view, const TestPoints& points, float epsilon, std::size_t begin,
                  std::size_t end, FacingCounts& counts) {
  for (std::size_t i = begin; i < end; ++i) {
    const Sight s = look(view, points, i, kGrazingCosine);
    if (!s.faces) continue;
    ++counts.facing;
    if (!s.measured) continue;
    if (s.residual < -epsilon) {
      ++counts.occluding;
    } else if (s.residual <= epsilon && (s.flags & ScenePixel::kSupport) == 0 &&
               s.cosine > kLikeNormal) {
      ++counts.matched;
    }
  }
}

/// Sums of eight interleaved partial sums: the upper triangle of the information, row by row, and
/// the right side.
struct PartialSums {
  static constexpr std::size_t kTriangle = 21;
  std::array<std::array<float, kLanes>, kTriangle + 6> sums = {};
  int pairs = 0;
};

/// What the equations measure motions against.
struct Pivot {
  Pivot(const View& view, const RecognitionModel& model)
      : x(dot3(view.R(0, 0), view.R(0, 1), view.R(0, 2), model.centre.x(), model.centre.y(),
               model.centre.z()) +
          view.t.x()),
        y(dot3(view.R(1, 0), view.R(1, 1), view.R(1, 2), model.centre.x(), model.centre.y(),
               model.centre.z()) +
          view.t.y()),
        z(dot3(view.R(2, 0), view.R(2, 1), view.R(2, 2), model.centre.x(), model.centre.y(),
               model.centre.z()) +
          view.t.z()),
        inverse_radius(2.0f / model.diameter) {}

  float x, y, z;
  float inverse_radius;
};

void add_equations(const View& view, const TestPoints& points, const Pivot& pivot, float epsilon,
                   std::size_t begin, std::size_t end, PartialSums& partial) {
  for (std::size_t i = begin; i < end; ++i) {
    const Sight s = look(view, points, i, 0.0f);
    if (!s.measured || (s.flags & ScenePixel::kSupport) != 0 ||
        ((s.flags & ScenePixel::kNormal) != 0 && s.cosine < kAlignedNormal) ||
        !(std::abs(s.residual) <= epsilon)) {
      continue;
    }
    const float ax = (s.px - pivot.x) * pivot.inverse_radius;
    const float ay = (s.py - pivot.y) * pivot.inverse_radius;
    const float az = (s.pz - pivot.z) * pivot.inverse_radius;
    const std::array<float, 6> row = {
        ay * s.nz - az * s.ny, az * s.nx - ax * s.nz, ax * s.ny - ay * s.nx, s.nx, s.ny, s.nz};
    const std::size_t lane = i % kLanes;
    std::size_t k = 0;
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t c = r; c < 6; ++c) partial.sums[k++][lane] += row[r] * row[c];
    }
    for (std::size_t r = 0; r < 6; ++r) partial.sums[k++][lane] += row[r] * s.residual;
    ++partial.pairs;
  }
}

NormalEquations total(const PartialSums& partial) {
  const auto sum = [&](std::size_t k) {
    const auto& s = partial.sums[k];
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
  };
  NormalEquations equations;
  std::size_t k = 0;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) {
      equations.information(r, c) = equations.information(c, r) = sum(k++);
    }
  }
  for (int r = 0; r < 6; ++r) equations.right[r] = sum(k++);
  equations.pairs = partial.pairs;
  return equations;
}

FacingCounts count_facing_portably(const ObservedScene& scene, const RecognitionModel& model,
                                   const Eigen::Isometry3f& T_camera_model, float epsilon,
                                   std::size_t begin, std::size_t end) {
  FacingCounts counts;
  count_points(View(scene, T_camera_model), model.test_points, epsilon, begin,
               std::min(end, model.test_points.size()), counts);
  return counts;
}

NormalEquations normal_equations_portably(const ObservedScene& scene, const RecognitionModel& model,
                                          const Eigen::Isometry3f& T_camera_model, float epsilon,
                                          std::size_t count) {
  const View view(scene, T_camera_model);
  PartialSums partial;
  add_equations(view, model.test_points, Pivot(view, model), epsilon, 0,
                std::min(count, model.test_points.size()), partial);
  return total(partial);
}

#if defined(__x86_64__)

/// Eight Sights.
struct Sights {
  __m256 px, py, pz;
  __m256 nx, ny, nz;
  __m256 faces;
  __m256 measured;
  __m256 residual;
  __m256 cosine;
  __m256i packed;  // normal and flags of the pixel
};

BINPICK_AVX2_INLINE Sights look_at_eight(const View& view, const TestPoints& points, std::size_t i,
                                         float grazing_cosine) {
  const __m256 x = _mm256_loadu_ps(points.x.data() + i);
  const __m256 y = _mm256_loadu_ps(points.y.data() + i);
  const __m256 z = _mm256_loadu_ps(points.z.data() + i);
  const __m256 nx = _mm256_loadu_ps(points.nx.data() + i);
  const __m256 ny = _mm256_loadu_ps(points.ny.data() + i);
  const __m256 nz = _mm256_loadu_ps(points.nz.data() + i);
  const __m256 zero = _mm256_setzero_ps();
  Sights s;
  s.px = _mm256_add_ps(row_times(view.R, 0, x, y, z), _mm256_set1_ps(view.t.x()));
  s.py = _mm256_add_ps(row_times(view.R, 1, x, y, z), _mm256_set1_ps(view.t.y()));
  s.pz = _mm256_add_ps(row_times(view.R, 2, x, y, z), _mm256_set1_ps(view.t.z()));
  s.nx = row_times(view.R, 0, nx, ny, nz);
  s.ny = row_times(view.R, 1, nx, ny, nz);
  s.nz = row_times(view.R, 2, nx, ny, nz);
  const __m256 away = dot3(s.nx, s.ny, s.nz, s.px, s.py, s.pz);
  const __m256 squared = dot3(s.px, s.py, s.pz, s.px, s.py, s.pz);
  const __m256 steep = _mm256_cmp_ps(
      _mm256_mul_ps(away, away),
      _mm256_mul_ps(_mm256_set1_ps(grazing_cosine * grazing_cosine), squared), _CMP_GE_OQ);
  s.faces = _mm256_and_ps(_mm256_and_ps(_mm256_cmp_ps(away, zero, _CMP_LT_OQ), steep),
                          _mm256_cmp_ps(s.pz, zero, _CMP_GT_OQ));

  const Projection& camera = view.camera;
  const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1.0f), s.pz);
  const __m256 cx = _mm256_set1_ps(camera.cx);
  const __m256 cy = _mm256_set1_ps(camera.cy);
  const __m256 half = _mm256_set1_ps(0.5f);
  const __m256 u = _mm256_add_ps(
      _mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(camera.fx), s.px), inverse), cx),
      half);
  const __m256 v = _mm256_add_ps(
      _mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(camera.fy), s.py), inverse), cy),
      half);
  const __m256 width = _mm256_set1_ps(static_cast<float>(camera.width));
  const __m256 height = _mm256_set1_ps(static_cast<float>(camera.height));
  const __m256 inside = _mm256_and_ps(
      _mm256_and_ps(_mm256_cmp_ps(u, zero, _CMP_GE_OQ), _mm256_cmp_ps(v, zero, _CMP_GE_OQ)),
      _mm256_and_ps(_mm256_cmp_ps(u, width, _CMP_LT_OQ), _mm256_cmp_ps(v, height, _CMP_LT_OQ)));
  s.faces = _mm256_and_ps(s.faces, inside);

  const __m256i column = _mm256_cvttps_epi32(u);
  const __m256i row = _mm256_cvttps_epi32(v);
  const __m256i index =
      _mm256_add_epi32(_mm256_mullo_epi32(row, _mm256_set1_epi32(camera.width)), column);
  const __m256i wanted = _mm256_castps_si256(s.faces);
  const int* words = reinterpret_cast<const int*>(view.pixels);  // two per pixel
  const __m256i none = _mm256_setzero_si256();
  const __m256 depth =
      _mm256_castsi256_ps(_mm256_mask_i32gather_epi32(none, words, index, wanted, 8));
  s.packed = _mm256_mask_i32gather_epi32(none, words + 1, index, wanted, 8);
  s.measured = _mm256_and_ps(s.faces, _mm256_cmp_ps(depth, zero, _CMP_GT_OQ));
  const __m256 qx = _mm256_mul_ps(
      _mm256_mul_ps(_mm256_sub_ps(_mm256_cvtepi32_ps(column), cx), _mm256_set1_ps(view.inverse_fx)),
      depth);
  const __m256 qy = _mm256_mul_ps(
      _mm256_mul_ps(_mm256_sub_ps(_mm256_cvtepi32_ps(row), cy), _mm256_set1_ps(view.inverse_fy)),
      depth);
  s.residual = dot3(s.nx, s.ny, s.nz, _mm256_sub_ps(qx, s.px), _mm256_sub_ps(qy, s.py),
                    _mm256_sub_ps(depth, s.pz));
  s.cosine = dot3(s.nx, s.ny, s.nz, normal_component<0>(s.packed), normal_component<1>(s.packed),
                  normal_component<2>(s.packed));
  return s;
}

BINPICK_AVX2_INLINE int count_lanes(__m256 mask) { return std::popcount(bits_of(mask)); }

BINPICK_AVX2_INLINE void add_to(std::array<float, kLanes>& sums, __m256 terms) {
  _mm256_storeu_ps(sums.data(), _mm256_add_ps(_mm256_loadu_ps(sums.data()), terms));
}

BINPICK_AVX2 FacingCounts count_facing_avx2(const ObservedScene& scene,
                                            const RecognitionModel& model,
                                            const Eigen::Isometry3f& T_camera_model, float epsilon,
                                            std::size_t begin, std::size_t end) {
  const View view(scene, T_camera_model);
  const TestPoints& points = model.test_points;
  end = std::min(end, points.size());
  FacingCounts counts;
  std::size_t i = begin;
  const __m256 band = _mm256_set1_ps(epsilon);
  const __m256 minus_band = _mm256_set1_ps(-epsilon);
  for (; i + kLanes <= end; i += kLanes) {
    const Sights s = look_at_eight(view, points, i, kGrazingCosine);
    counts.facing += count_lanes(s.faces);
    const __m256 occluding =
        _mm256_and_ps(s.measured, _mm256_cmp_ps(s.residual, minus_band, _CMP_LT_OQ));
    counts.occluding += count_lanes(occluding);
    const __m256 near = _mm256_and_ps(_mm256_cmp_ps(s.residual, minus_band, _CMP_GE_OQ),
                                      _mm256_cmp_ps(s.residual, band, _CMP_LE_OQ));
    const __m256 alike = _mm256_cmp_ps(s.cosine, _mm256_set1_ps(kLikeNormal), _CMP_GT_OQ);
    const __m256 matched = _mm256_andnot_ps(has_flag(s.packed, ScenePixel::kSupport),
                                            _mm256_and_ps(_mm256_and_ps(s.measured, near), alike));
    counts.matched += count_lanes(matched);
  }
  count_points(view, points, epsilon, i, end, counts);
  return counts;
}

BINPICK_AVX2 NormalEquations normal_equations_avx2(const ObservedScene& scene,
                                                   const RecognitionModel& model,
                                                   const Eigen::Isometry3f& T_camera_model,
                                                   float epsilon, std::size_t count) {
  const View view(scene, T_camera_model);
  const TestPoints& points = model.test_points;
  const Pivot pivot(view, model);
  const std::size_t end = std::min(count, points.size());
  PartialSums partial;
  std::size_t i = 0;
  const __m256 band = _mm256_set1_ps(epsilon);
  const __m256 unsigned_bits = _mm256_castsi256_ps(_mm256_set1_epi32(0x7fffffff));
  const __m256 inverse_radius = _mm256_set1_ps(pivot.inverse_radius);
  for (; i + kLanes <= end; i += kLanes) {
    const Sights s = look_at_eight(view, points, i, 0.0f);
    const __m256 near = _mm256_cmp_ps(_mm256_and_ps(s.residual, unsigned_bits), band, _CMP_LE_OQ);
    const __m256 unlike =
        _mm256_and_ps(has_flag(s.packed, ScenePixel::kNormal),
                      _mm256_cmp_ps(s.cosine, _mm256_set1_ps(kAlignedNormal), _CMP_LT_OQ));
    const __m256 out = _mm256_or_ps(has_flag(s.packed, ScenePixel::kSupport), unlike);
    const __m256 used = _mm256_andnot_ps(out, _mm256_and_ps(s.measured, near));
    const int pairs = count_lanes(used);
    if (pairs == 0) continue;
    partial.pairs += pairs;
    // Lanes that take no part add zeros.
    const __m256 nx = _mm256_and_ps(s.nx, used);
    const __m256 ny = _mm256_and_ps(s.ny, used);
    const __m256 nz = _mm256_and_ps(s.nz, used);
    const __m256 residual = _mm256_and_ps(s.residual, used);
    const __m256 ax = _mm256_mul_ps(_mm256_sub_ps(s.px, _mm256_set1_ps(pivot.x)), inverse_radius);
    const __m256 ay = _mm256_mul_ps(_mm256_sub_ps(s.py, _mm256_set1_ps(pivot.y)), inverse_radius);
    const __m256 az = _mm256_mul_ps(_mm256_sub_ps(s.pz, _mm256_set1_ps(pivot.z)), inverse_radius);
    const __m256 row[6] = {_mm256_sub_ps(_mm256_mul_ps(ay, nz), _mm256_mul_ps(az, ny)),
                           _mm256_sub_ps(_mm256_mul_ps(az, nx), _mm256_mul_ps(ax, nz)),
                           _mm256_sub_ps(_mm256_mul_ps(ax, ny), _mm256_mul_ps(ay, nx)),
                           nx,
                           ny,
                           nz};
    std::size_t k = 0;
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t c = r; c < 6; ++c) {
        add_to(partial.sums[k++], _mm256_mul_ps(row[r], row[c]));
      }
    }
    for (std::size_t r = 0; r < 6; ++r) add_to(partial.sums[k++], _mm256_mul_ps(row[r], residual));
  }
  add_equations(view, points, pivot, epsilon, i, end, partial);
  return total(partial);
}

#endif

}  // namespace

PointKernels portable_kernels() noexcept {
  return {count_facing_portably, normal_equations_portably};
}

PointKernels best_kernels() noexcept {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt"))
    return {count_facing_avx2, normal_equations_avx2};
#endif
  return portable_kernels();
}

}  // namespace binpick
