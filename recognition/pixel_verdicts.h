#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"
#include "recognition/sensor_estimate.h"

namespace binpick {

/// What a pixel that a model covers says about the model's pose; see HypothesisEvidence.
enum class Verdict : std::uint8_t {
  kOutside,
  kMatched,
  kBadNormal,
  kSeenThrough,
  kNearOccluded,
  kFarOccluded,
  kMissing,
  kOnSupport,
  kClaimed
};
constexpr std::size_t kVerdicts = 9;

/// What the verdicts on one model at one pose depend on besides the pixels.
struct VerdictRules {
  Eigen::Matrix3f R_camera_model = Eigen::Matrix3f::Identity();
  const RenderMesh* mesh = nullptr;
  float roughest = 0.0f;   ///< triangles rougher than this have normals that mean little
  float tolerance = 0.0f;  ///< of the model, m
  SensorEstimate sensor;
  float pixel_width = 0.0f;   ///< at z = 1
  std::int32_t claimant = 0;  ///< whose claims are its own

  /// Square of the largest residual along the normal that counts as agreement, m^2.
  [[nodiscard]] float limit_squared(float z, float n_ray) const noexcept {
    constexpr float kSigmas = 3.0f;
    return tolerance * tolerance +
           kSigmas * kSigmas * sensor.normal_variance(z, n_ray, pixel_width);
  }
};

/// A row of a rendered model and the same pixels of the scene.
struct PixelRow {
  std::size_t size = 0;
  const float* depth = nullptr;            ///< of the model
  const std::int32_t* triangle = nullptr;  ///< -1 outside the model
  const ScenePixel* scene = nullptr;
  const std::int32_t* claims = nullptr;  ///< owners of the pixels, -1 for none; or null
  const float* ray_x = nullptr;          ///< x / z
  float ray_y = 0.0f;                    ///< y / z
};

/// What is found out about a row. Verdicts of pixels outside the model are left as they are; masks
/// hold a bit per pixel, lowest first, and must be clear.
struct VerdictRow {
  Verdict* verdicts = nullptr;
  std::uint64_t* covered = nullptr;
  std::uint64_t* seen_through = nullptr;
  std::uint64_t* near_occluded = nullptr;
};

/// Sums over pixels, in eight interleaved parts: pixel i of a row adds to part i mod 8.
struct VerdictSums {
  static constexpr std::size_t kParts = 8;
  using Parts = std::array<float, kParts>;

  std::array<int, kVerdicts> counts = {};
  int normals = 0;                    ///< matched pixels whose normals were compared
  Parts residual = {};                ///< of matched pixels, along the normal, m
  Parts residual_squares = {};        ///< in limits of agreement
  Parts normal_error = {};            ///< 1 - cos of the angle between the normals
  std::array<Parts, 6> scatter = {};  ///< of the matched normals: xx, xy, xz, yy, yz, zz

  [[nodiscard]] int count(Verdict verdict) const {
    return counts[static_cast<std::size_t>(verdict)];
  }
  [[nodiscard]] static float total(const Parts& s) noexcept {
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
  }
  [[nodiscard]] Eigen::Matrix3f normal_scatter() const;
};

/// Judges the pixels of a row. Exists twice, as the kernels over points do: portable, and with AVX2
/// eight pixels at a time, with the same bits. Allocates nothing.
using JudgeRow = void (*)(const PixelRow& row, const VerdictRules& rules, const VerdictRow& judged,
                          VerdictSums& sums);

[[nodiscard]] JudgeRow portable_judge_row() noexcept;
/// The fastest that this processor has.
[[nodiscard]] JudgeRow best_judge_row() noexcept;

}  // namespace binpick
