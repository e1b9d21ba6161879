#pragma once

#include "recognition/observed_scene.h"

#if defined(__x86_64__)
#include <immintrin.h>
#define BINPICK_AVX2 __attribute__((target("avx2,popcnt")))
#define BINPICK_AVX2_INLINE __attribute__((target("avx2,popcnt"), always_inline)) inline
#endif

// What the kernels that look at eight points or pixels at a time have in common: products in one
// order of additions, so that scalar and vector paths give the same bits, and scene pixels as they
// are packed.

namespace binpick {

inline constexpr float kNormalUnit = 1.0f / 127.0f;  // of a stored normal's components

// Written out, for the order of additions is that of the vector path.
inline float dot3(float a, float b, float c, float x, float y, float z) {
  return (a * x + b * y) + c * z;
}

#if defined(__x86_64__)

// Masks have all bits of a lane set or none.

BINPICK_AVX2_INLINE __m256 dot3(__m256 a, __m256 b, __m256 c, __m256 x, __m256 y, __m256 z) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a, x), _mm256_mul_ps(b, y)),
                       _mm256_mul_ps(c, z));
}

BINPICK_AVX2_INLINE __m256 row_times(const Eigen::Matrix3f& R, int row, __m256 x, __m256 y,
                                     __m256 z) {
  return dot3(_mm256_set1_ps(R(row, 0)), _mm256_set1_ps(R(row, 1)), _mm256_set1_ps(R(row, 2)), x, y,
              z);
}

/// Byte `k` of each lane, the second half of a ScenePixel, as a component of its normal.
template <int kByte>
BINPICK_AVX2_INLINE __m256 normal_component(__m256i packed) {
  const __m256i byte = _mm256_srai_epi32(_mm256_slli_epi32(packed, 24 - 8 * kByte), 24);
  return _mm256_mul_ps(_mm256_set1_ps(kNormalUnit), _mm256_cvtepi32_ps(byte));
}

/// The lanes whose pixel, of which `packed` is the second half, has `flag`.
BINPICK_AVX2_INLINE __m256 has_flag(__m256i packed, int flag) {
  const __m256i wanted = _mm256_set1_epi32(flag << 24);
  return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(packed, wanted), wanted));
}

BINPICK_AVX2_INLINE unsigned bits_of(__m256 mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(mask));
}

#endif

}  // namespace binpick
