#include "recognition/pose_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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

double mspd(const Eigen::Isometry3d& T_camera_estimated, const Eigen::Isometry3d& T_camera_true,
            std::span<const Eigen::Vector3f> points, std::span<const Eigen::Isometry3d> symmetries,
            const CameraIntrinsics& camera) {
  const auto project = [&](const Eigen::Vector3d& p) {
    return p.z() > 0.0 ? Eigen::Vector2d(camera.fx * p.x() / p.z(), camera.fy * p.y() / p.z())
                       : Eigen::Vector2d::Constant(kInfinity).eval();
  };
  double least = kInfinity;
  for_each_equivalent(T_camera_true, symmetries, [&](const Eigen::Isometry3d& T_equivalent) {
    double largest = 0.0;
    for (const Eigen::Vector3f& point : points) {
      const Eigen::Vector3d p = point.cast<double>();
      const double distance = (project(T_camera_estimated * p) - project(T_equivalent * p)).norm();
      largest = std::max(largest, std::isfinite(distance) ? distance : kInfinity);
    }
    least = std::min(least, largest);
  });
  return least;
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

std::size_t InstanceMatching::true_positives() const {
  return static_cast<std::size_t>(std::count(found.begin(), found.end(), true));
}

double InstanceMatching::recall() const {
  return found.empty() ? 1.0
                       : static_cast<double>(true_positives()) / static_cast<double>(found.size());
}

InstanceMatching match_instances(
    std::span<const double> scores, std::size_t instances, double limit,
    const std::function<double(std::size_t estimate, std::size_t instance)>& error) {
  InstanceMatching matching{std::vector<std::ptrdiff_t>(scores.size(), -1),
                            std::vector<bool>(instances, false)};
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  for (const std::size_t estimate : order) {
    double least = limit;
    for (std::size_t instance = 0; instance < instances; ++instance) {
      if (matching.found[instance]) continue;
      const double e = error(estimate, instance);
      if (!(e < least)) continue;
      least = e;
      matching.truth_of[estimate] = static_cast<std::ptrdiff_t>(instance);
    }
    if (matching.truth_of[estimate] >= 0) {
      matching.found[static_cast<std::size_t>(matching.truth_of[estimate])] = true;
    }
  }
  return matching;
}

}  // namespace binpick
