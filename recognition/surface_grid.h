#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "recognition/pair_descriptor.h"

namespace binpick {

/// Oriented points in the cells of a dense grid, for queries of one radius.
class SurfaceGrid {
 public:
  /// For points within `box`. Memory is bounded for any radius.
  SurfaceGrid(const Eigen::AlignedBox3f& box, float radius) : low_(box.min()) {
    constexpr float kMostCells = 64.0f;  // per axis
    const float extent = std::max(box.sizes().maxCoeff(), 1e-30f);
    // With cells twice as wide as the radius, neighbours are in 2 x 2 x 2 of them.
    inverse_cell_ = 1.0f / std::max(2.0f * radius, extent / kMostCells);
    size_ = (box.sizes() * inverse_cell_).cast<int>() + Eigen::Vector3i::Constant(1);
    heads_.assign(static_cast<std::size_t>(size_.prod()), -1);
  }

  void add(const OrientedPoint& point) {
    const Eigen::Vector3i cell = ((point.p - low_) * inverse_cell_)
                                     .cast<int>()
                                     .cwiseMax(Eigen::Vector3i::Zero())
                                     .cwiseMin(size_ - Eigen::Vector3i::Ones());
    std::int32_t& head = heads_[index_of(cell.x(), cell.y(), cell.z())];
    next_.push_back(head);
    head = static_cast<std::int32_t>(points_.size());
    points_.push_back(point);
  }

  [[nodiscard]] const std::vector<OrientedPoint>& points() const noexcept { return points_; }

  /// Calls `visit` for all points within the radius of `p` and for some beyond, until it returns
  /// true; returns whether it did.
  template <class Visit>
  bool any_near(const Eigen::Vector3f& p, const Visit& visit) const {
    const Eigen::Array3f at = (p - low_).array() * inverse_cell_ - 0.5f;
    const Eigen::Vector3i corner = at.floor().max(-2.0f).min(1e6f).cast<int>();
    const Eigen::Vector3i from = corner.cwiseMax(Eigen::Vector3i::Zero());
    const Eigen::Vector3i to =
        (corner + Eigen::Vector3i::Ones()).cwiseMin(size_ - Eigen::Vector3i::Ones());
    for (int z = from.z(); z <= to.z(); ++z) {
      for (int y = from.y(); y <= to.y(); ++y) {
        for (int x = from.x(); x <= to.x(); ++x) {
          for (std::int32_t i = heads_[index_of(x, y, z)]; i >= 0;
               i = next_[static_cast<std::size_t>(i)]) {
            if (visit(points_[static_cast<std::size_t>(i)])) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  [[nodiscard]] std::size_t index_of(int x, int y, int z) const {
    return static_cast<std::size_t>((z * size_.y() + y) * size_.x() + x);
  }

  Eigen::Vector3f low_;
  float inverse_cell_ = 0.0f;
  Eigen::Vector3i size_;
  std::vector<std::int32_t> heads_;  // by cell
  std::vector<std::int32_t> next_;   // by point
  std::vector<OrientedPoint> points_;
};

}  // namespace binpick
