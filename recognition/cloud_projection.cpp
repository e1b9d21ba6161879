#include "recognition/cloud_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace binpick {
namespace {

constexpr double kPointsPerPixel = 2.0;
constexpr double kMostPixelsPerSide = 1600.0;
constexpr float kSameSurface = 1.015f;  // depths within 1.5 % of the nearest are averaged

/// Slope and intercept of pixel = focal * tangent + principal, and the rms residual in pixels.
struct AxisFit {
  double focal = 0.0;
  double principal = 0.0;
  double residual = std::numeric_limits<double>::infinity();
};

class LineFit {
 public:
  void add(double x, double y) {
    n_ += 1.0;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
    yy_ += y * y;
  }
  [[nodiscard]] AxisFit solve() const {
    const double variance = xx_ - x_ * x_ / n_;
    const double covariance = xy_ - x_ * y_ / n_;
    if (!(n_ >= 100.0) || !(variance > 0.0)) return {};
    AxisFit fit;
    fit.focal = covariance / variance;
    fit.principal = (y_ - fit.focal * x_) / n_;
    fit.residual = std::sqrt(std::max(0.0, (yy_ - y_ * y_ / n_ - fit.focal * covariance) / n_));
    return fit;
  }

 private:
  double n_ = 0.0, x_ = 0.0, y_ = 0.0, xx_ = 0.0, xy_ = 0.0, yy_ = 0.0;
};

/// The pixels of an organised cloud, if a pinhole camera at the viewpoint explains them.
std::optional<RangeImage> keep_pixels(const PointCloud& cloud, const Eigen::Vector3d& viewpoint) {
  constexpr double kMostResidual = 0.5;
  if (!cloud.organised()) return std::nullopt;
  LineFit horizontal, vertical;
  RangeImage image;
  image.depth.assign(cloud.points.size(), 0.0f);
  const auto width = static_cast<std::size_t>(cloud.width);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite()) continue;
    const Eigen::Vector3d p = cloud.points[i].cast<double>() - viewpoint;
    if (!(p.z() > 0.0)) {
      if (p.isZero()) continue;
      return std::nullopt;
    }
    horizontal.add(p.x() / p.z(), static_cast<double>(i % width));
    vertical.add(p.y() / p.z(), static_cast<double>(i / width));
    image.depth[i] = static_cast<float>(p.z());
  }
  const AxisFit u = horizontal.solve();
  const AxisFit v = vertical.solve();
  if (u.residual > kMostResidual || v.residual > kMostResidual || u.focal <= 0.0 ||
      v.focal <= 0.0) {
    return std::nullopt;
  }
  image.intrinsics = {cloud.width, cloud.height, u.focal, v.focal, u.principal, v.principal};
  return image;
}

/// A camera at `viewpoint` that looks at `target`.
Eigen::Isometry3d looking_at(const Eigen::Vector3d& viewpoint, const Eigen::Vector3d& target) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = viewpoint;
  const Eigen::Vector3d forward = (target - viewpoint).normalized();
  const Eigen::Vector3d down =
      std::abs(forward.y()) < 0.9 ? Eigen::Vector3d(0.0, 1.0, 0.0) : Eigen::Vector3d(0.0, 0.0, 1.0);
  const Eigen::Vector3d right = down.cross(forward).normalized();
  T.linear() << right, forward.cross(right), forward;
  return T;
}

struct Tangents {
  std::vector<Eigen::Vector3f> points;  // x / z, y / z, z
  Eigen::AlignedBox2f box;
};

Tangents tangents_of(const std::vector<Eigen::Vector3d>& points,
                     const Eigen::Isometry3d& T_cloud_camera) {
  constexpr double kWidestTangent = 3.0;
  const Eigen::Isometry3d T_camera_cloud = T_cloud_camera.inverse();
  Tangents tangents;
  for (const Eigen::Vector3d& p_cloud : points) {
    const Eigen::Vector3d p = T_camera_cloud * p_cloud;
    if (!(p.z() > 0.0) || p.head<2>().cwiseAbs().maxCoeff() > kWidestTangent * p.z()) continue;
    tangents.points.emplace_back((p / p.z()).cast<float>().head<2>().homogeneous());
    tangents.points.back().z() = static_cast<float>(p.z());
    tangents.box.extend(tangents.points.back().head<2>());
  }
  return tangents;
}

CameraIntrinsics frame_of(const Tangents& tangents, double focal) {
  const Eigen::Vector2f size = tangents.box.sizes();
  CameraIntrinsics camera;
  camera.fx = camera.fy = focal;
  camera.cx = 1.0 - focal * static_cast<double>(tangents.box.min().x());
  camera.cy = 1.0 - focal * static_cast<double>(tangents.box.min().y());
  camera.width = static_cast<int>(focal * static_cast<double>(size.x())) + 3;
  camera.height = static_cast<int>(focal * static_cast<double>(size.y())) + 3;
  return camera;
}

std::size_t pixel_of(const CameraIntrinsics& camera, const Eigen::Vector3f& tangent) {
  const auto u =
      static_cast<std::size_t>(camera.fx * static_cast<double>(tangent.x()) + camera.cx + 0.5);
  const auto v =
      static_cast<std::size_t>(camera.fy * static_cast<double>(tangent.y()) + camera.cy + 0.5);
  return v * static_cast<std::size_t>(camera.width) + u;
}

double points_per_occupied_pixel(const Tangents& tangents, const CameraIntrinsics& camera) {
  std::vector<bool> occupied(static_cast<std::size_t>(camera.width) *
                             static_cast<std::size_t>(camera.height));
  std::size_t count = 0;
  for (const Eigen::Vector3f& tangent : tangents.points) {
    auto pixel = occupied[pixel_of(camera, tangent)];
    if (!pixel) ++count;
    pixel = true;
  }
  return static_cast<double>(tangents.points.size()) / static_cast<double>(count);
}

CameraIntrinsics choose_camera(const Tangents& tangents) {
  const double extent = std::max(static_cast<double>(tangents.box.sizes().maxCoeff()), 1e-6);
  const double finest = kMostPixelsPerSide / extent;
  double focal = std::min(finest, std::sqrt(static_cast<double>(tangents.points.size())) / extent);
  for (int i = 0; i < 4; ++i) {
    const double density = points_per_occupied_pixel(tangents, frame_of(tangents, focal));
    focal = std::min(finest, focal * std::sqrt(density / kPointsPerPixel));
  }
  return frame_of(tangents, focal);
}

RangeImage rasterise(const Tangents& tangents, const CameraIntrinsics& camera) {
  RangeImage image;
  image.intrinsics = camera;
  const auto size =
      static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  std::vector<float> nearest(size, std::numeric_limits<float>::infinity());
  for (const Eigen::Vector3f& tangent : tangents.points) {
    float& z = nearest[pixel_of(camera, tangent)];
    z = std::min(z, tangent.z());
  }
  std::vector<float> count(size, 0.0f);
  image.depth.assign(size, 0.0f);
  for (const Eigen::Vector3f& tangent : tangents.points) {
    const std::size_t pixel = pixel_of(camera, tangent);
    if (tangent.z() > kSameSurface * nearest[pixel]) continue;
    image.depth[pixel] += tangent.z();
    count[pixel] += 1.0f;
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (count[i] > 0.0f) image.depth[i] /= count[i];
  }
  return image;
}

}  // namespace

ProjectedCloud project_cloud(const PointCloud& cloud, const Eigen::Vector3d& viewpoint) {
  ProjectedCloud projected;
  projected.T_cloud_camera.translation() = viewpoint;
  if (auto image = keep_pixels(cloud, viewpoint)) {
    projected.image = std::move(*image);
    return projected;
  }
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : cloud.points) {
    if (!p.allFinite()) continue;
    points.push_back(p.cast<double>());
    mean += points.back();
  }
  if (points.empty()) return projected;
  mean /= static_cast<double>(points.size());
  if (!((mean - viewpoint).norm() > 0.0)) return projected;
  projected.T_cloud_camera = looking_at(viewpoint, mean);
  const Tangents tangents = tangents_of(points, projected.T_cloud_camera);
  if (tangents.points.empty()) return projected;
  projected.image = rasterise(tangents, choose_camera(tangents));
  return projected;
}

}  // namespace binpick
