#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "recognition/pair_descriptor.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// A stored model pair: F_uv^-1, all that T = F_wx F_uv^-1 (IJRR 2012, eq. (2)) needs of it.
using PairFrame = Eigen::Matrix<float, 3, 4>;

/// T = F_wx F_uv^-1, the pose that brings a model pair onto a scene pair. IJRR 2012, eq. (2).
[[nodiscard]] inline Eigen::Isometry3f hypothesis_pose(const Eigen::Isometry3f& F_wx,
                                                       const PairFrame& F_uv_inverse) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.linear().noalias() = F_wx.linear() * F_uv_inverse.leftCols<3>();
  T.translation().noalias() = F_wx.linear() * F_uv_inverse.col(3) + F_wx.translation();
  return T;
}

/// Which pairs enter the table.
struct PairTableOptions {
  float width = 0.0f;            ///< d, m
  float tolerance = 0.0f;        ///< delta_d, m
  double kept_fraction = 1.0;    ///< K: the most crowded cells go until no more than K remains
  bool drop_coplanar = false;    ///< leave out pairs that lie in one plane
  bool reduce_symmetry = false;  ///< store one of the pairs that symmetries map onto each other
};

/// The three-dimensional hash table over (f_2, f_3, f_4) with one list per cell and model, as flat
/// arrays. IJRR 2012, section 4.1. All models share one table.
class PairTable {
 public:
  PairTable() = default;
  /// On up to `jobs` threads; the same for any number.
  PairTable(const std::vector<RecognitionModel>& models, const PairTableOptions& options,
            int jobs = 1);

  /// The cell of a descriptor, in constant time.
  [[nodiscard]] static std::uint32_t cell(const PairDescriptor& f) noexcept;
  /// Per angle, some 9.5 degrees each; odd, so that right angles fall into the middle of a bin.
  static constexpr std::uint32_t kBins = 19;
  static constexpr std::uint32_t kCells = kBins * kBins * kBins;

  /// The pairs of `model` in `cell`.
  [[nodiscard]] std::span<const PairFrame> pairs(std::uint32_t cell, std::size_t model) const {
    const std::size_t list = cell * models_ + model;
    return {frames_.data() + offsets_[list], frames_.data() + offsets_[list + 1]};
  }

  [[nodiscard]] std::size_t size() const noexcept { return frames_.size(); }
  /// Share of the sampled pairs that is stored: the K of eq. (11).
  [[nodiscard]] double kept_fraction() const noexcept { return kept_fraction_; }

 private:
  std::size_t models_ = 0;
  std::vector<std::uint32_t> offsets_ = {0};  // by (cell, model)
  std::vector<PairFrame> frames_;
  double kept_fraction_ = 1.0;
};

/// The pairs of one model that lie in one plane, whatever their cell: what a table without coplanar
/// pairs leaves out. They fix the plane, but not the position in it.
[[nodiscard]] std::vector<PairFrame> coplanar_pairs(const RecognitionModel& model,
                                                    const PairTableOptions& options);

}  // namespace binpick
