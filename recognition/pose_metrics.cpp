#include "recognition/pose_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binpick {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Calls `visit` with every pose that looks like `T_true`.
template <class Visit>
void for_each_equivalent(const Eigen::Isometry3d& T_true,
                         std::span<const Eigen::Isometry3d> symmetries, const Visit& visit) {
  if (symmetries.empty()) visit(T_true);
  for (const Eigen::Isometry3d& T_model_equivalent : symmetries) {
    visit(Eigen::Isometry3d(T_true * T_model_equivalent));
  }
}

}  // namespace

double mssd(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
            std::span<const Eigen::Vector3f> points,
            std::span<const Eigen::Isometry3d> symmetries) {
  double least = kInfinity;
  for_each_equivalent(T_true, symmetries, [&](const Eigen::Isometry3d& T_equivalent) {
    double largest = 0.0;
    for (const Eigen::Vector3f& point : points) {
      const Eigen::Vector3d p = point.cast<double>();
      largest = std::max(largest, (T_estimated * p - T_equivalent * p).squaredNorm());
      if (largest >= least) break;
    }
    least = std::min(least, largest);
  });
  return std::sqrt(least);
}

double add(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
           std::span<const Eigen::Vector3f> points, std::span<const Eigen::Isometry3d> symmetries) {
  double least = kInfinity;
  for_each_equivalent(T_true, symmetries, [&](const Eigen::Isometry3d& T_equivalent) {
    double sum = 0.0;
    for (const Eigen::Vector3f& point : points) {
      const Eigen::Vector3d p = point.cast<double>();
      sum += (T_estimated * p - T_equivalent * p).norm();
    }
    least = std::min(least, sum / static_cast<double>(points.size()));
  });
  return least;
}

double adi(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
           std::span<const Eigen::Vector3f> points) {
  const Eigen::Isometry3d T_true_estimated = T_true.inverse() * T_estimated;
  double sum = 0.0;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3f p = (T_true_estimated * point.cast<double>()).cast<float>();
    float closest = std::numeric_limits<float>::infinity();
    for (const Eigen::Vector3f& other : points) {
      closest = std::min(closest, (p - other).squaredNorm());
    }
    sum += std::sqrt(static_cast<double>(closest));
  }
  return sum / static_cast<double>(points.size());
}

double rms_error(std::span<const Eigen::Vector3d> p, std::span<const Eigen::Vector3d> q,
                 const Eigen::Isometry3d& T) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (p[i] - T * q[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(p.size()));
}

PoseError pose_error(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true,
                     std::span<const Eigen::Isometry3d> symmetries) {
  PoseError best{kInfinity, kInfinity};
  for_each_equivalent(T_true, symmetries, [&](const Eigen::Isometry3d& T_equivalent) {
    const Eigen::AngleAxisd rotation(T_equivalent.linear().transpose() * T_estimated.linear());
    const double translation = (T_equivalent.translation() - T_estimated.translation()).norm();
    const double angle = std::abs(rotation.angle());
    if (angle < best.rotation) best = {angle, translation};
  });
  return best;
}

}  // namespace binpick
