#include "recognition/cloud_projection.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "recognition/parallel_for.h"

namespace binpick {
namespace {

constexpr double kPointsPerPixel = 2.0;
constexpr double kMostPixelsPerSide = 1600.0;
constexpr int kChunk = 16384;
constexpr int kRowsPerChunk = 16;
constexpr std::size_t kFitStride = 7;   // of the points that a camera is fitted to
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

/// A sparse sample of an organised cloud's points with their pixels.
template <class Visit>
void for_some_pixels(const PointCloud& cloud, const Visit& visit) {
  const auto width = static_cast<std::size_t>(cloud.width);
  for (std::size_t i = 0; i < cloud.points.size(); i += kFitStride) {
    if (!cloud.points[i].allFinite() || cloud.points[i].isZero()) continue;
    visit(cloud.points[i].cast<double>(), static_cast<double>(i % width),
          static_cast<double>(i / width));
  }
}

struct PinholeFit {
  Eigen::Vector3d viewpoint;
  AxisFit u, v;

  [[nodiscard]] double residual() const { return std::max(u.residual, v.residual); }
};

/// The pinhole camera at `viewpoint` that fits best.
PinholeFit fit_pinhole(const PointCloud& cloud, const Eigen::Vector3d& viewpoint) {
  LineFit horizontal, vertical;
  bool in_front = true;
  for_some_pixels(cloud, [&](const Eigen::Vector3d& p_cloud, double u, double v) {
    const Eigen::Vector3d p = p_cloud - viewpoint;
    in_front = in_front && p.z() > 0.0;
    if (!in_front) return;
    horizontal.add(p.x() / p.z(), u);
    vertical.add(p.y() / p.z(), v);
  });
  if (!in_front) return {viewpoint, {}, {}};
  return {viewpoint, horizontal.solve(), vertical.solve()};
}

/// Where the pixels say that the sensor is. A camera at (c_x, c_y, c_z) gives
/// u z = f x + c_u z + c_z u + constant, which is linear in the unknowns; so for v.
Eigen::Vector3d locate_sensor(const PointCloud& cloud) {
  std::array<Eigen::Matrix4d, 2> information = {Eigen::Matrix4d::Zero(), Eigen::Matrix4d::Zero()};
  std::array<Eigen::Vector4d, 2> right = {Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
  for_some_pixels(cloud, [&](const Eigen::Vector3d& p, double u, double v) {
    const Eigen::Vector4d by_u(p.x(), p.z(), u, 1.0);
    const Eigen::Vector4d by_v(p.y(), p.z(), v, 1.0);
    information[0] += by_u * by_u.transpose();
    information[1] += by_v * by_v.transpose();
    right[0] += by_u * (u * p.z());
    right[1] += by_v * (v * p.z());
  });
  const Eigen::Vector4d u = information[0].ldlt().solve(right[0]);  // f, c_u, c_z, constant
  const Eigen::Vector4d v = information[1].ldlt().solve(right[1]);
  return {-(u[3] + u[1] * u[2]) / u[0], -(v[3] + v[1] * v[2]) / v[0], 0.5 * (u[2] + v[2])};
}

/// The pixels of an organised cloud, if a pinhole camera explains them.
std::optional<ProjectedCloud> keep_pixels(const PointCloud& cloud, const Eigen::Vector3d& viewpoint,
                                          int jobs) {
  constexpr double kMostResidual = 0.5;  // pixels
  constexpr double kExact = 0.02;
  if (!cloud.organised()) return std::nullopt;
  PinholeFit fit = fit_pinhole(cloud, viewpoint);
  if (!(fit.residual() < kExact)) {
    const Eigen::Vector3d located = locate_sensor(cloud);
    const PinholeFit moved = fit_pinhole(cloud, located.allFinite() ? located : viewpoint);
    if (moved.residual() < kExact) fit = moved;
  }
  if (!(fit.residual() < kMostResidual) || fit.u.focal <= 0.0 || fit.v.focal <= 0.0) {
    return std::nullopt;
  }
  ProjectedCloud projected;
  projected.T_cloud_camera.translation() = fit.viewpoint;
  RangeImage& image = projected.image;
  image.intrinsics = {cloud.width, cloud.height,    fit.u.focal,
                      fit.v.focal, fit.u.principal, fit.v.principal};
  image.depth.assign(cloud.points.size(), 0.0f);
  const auto z0 = static_cast<float>(fit.viewpoint.z());
  parallel_chunks(
      static_cast<int>(cloud.points.size()), kChunk, jobs, [&](int, int begin, int end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const Eigen::Vector3f& p = cloud.points[i];
          if (p.allFinite() && p.z() > z0) image.depth[i] = p.z() - z0;
        }
      });
  return projected;
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

/// The mean of the finite points, if there is one.
std::optional<Eigen::Vector3d> mean_of(const std::vector<Eigen::Vector3f>& points, int jobs) {
  struct Part {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t count = 0;
  };
  const auto size = static_cast<int>(points.size());
  std::vector<Part> parts(static_cast<std::size_t>((size + kChunk - 1) / kChunk));
  parallel_chunks(size, kChunk, jobs, [&](int chunk, int begin, int end) {
    Part part;
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector3f& p = points[static_cast<std::size_t>(i)];
      if (!p.allFinite()) continue;
      part.sum += p.cast<double>();
      ++part.count;
    }
    parts[static_cast<std::size_t>(chunk)] = part;
  });
  Part all;
  for (const Part& part : parts) {
    all.sum += part.sum;
    all.count += part.count;
  }
  if (all.count == 0) return std::nullopt;
  return all.sum / static_cast<double>(all.count);
}

Tangents tangents_of(const std::vector<Eigen::Vector3f>& points,
                     const Eigen::Isometry3d& T_cloud_camera, int jobs) {
  constexpr float kWidestTangent = 3.0f;
  const Eigen::Isometry3d T_camera_cloud = T_cloud_camera.inverse();
  const auto size = static_cast<int>(points.size());
  Tangents tangents;
  tangents.points.resize(points.size());
  struct Part {
    int begin = 0;
    int end = 0;
    Eigen::AlignedBox2f box;
  };
  std::vector<Part> parts(static_cast<std::size_t>((size + kChunk - 1) / kChunk));
  parallel_chunks(size, kChunk, jobs, [&](int chunk, int begin, int end) {
    Part& part = parts[static_cast<std::size_t>(chunk)];
    part.begin = part.end = begin;
    for (int i = begin; i < end; ++i) {
      // In double precision: a cloud may lie far from its origin.
      const Eigen::Vector3f p =
          (T_camera_cloud * points[static_cast<std::size_t>(i)].cast<double>()).cast<float>();
      // Written so that what is not a number fails.
      if (!(p.z() > 0.0f && std::abs(p.x()) < kWidestTangent * p.z() &&
            std::abs(p.y()) < kWidestTangent * p.z() &&
            p.z() < std::numeric_limits<float>::infinity())) {
        continue;
      }
      const Eigen::Vector3f tangent(p.x() / p.z(), p.y() / p.z(), p.z());
      tangents.points[static_cast<std::size_t>(part.end++)] = tangent;
      part.box.extend(tangent.head<2>());
    }
  });
  auto end = tangents.points.begin();
  for (const Part& part : parts) {
    const auto first = tangents.points.begin() + part.begin;
    const auto last = tangents.points.begin() + part.end;
    end = end == first ? last : std::move(first, last, end);
    if (!part.box.isEmpty()) tangents.box.extend(part.box);
  }
  tangents.points.erase(end, tangents.points.end());
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

/// The points in a camera's pixels.
struct Raster {
  CameraIntrinsics camera;
  std::vector<std::uint32_t> pixels;   // of the points
  std::vector<std::uint8_t> occupied;  // 1 for every pixel that holds a point

  [[nodiscard]] double points_per_occupied_pixel() const {
    return static_cast<double>(pixels.size()) /
           static_cast<double>(std::count(occupied.begin(), occupied.end(), 1));
  }
};

/// Calls visit(i, pixel) for every point i. Threads own bands of the image, so that the points of a
/// pixel are visited by one thread, in their order.
template <class Visit>
void for_points_by_pixel(const Raster& raster, int jobs, const Visit& visit) {
  const std::size_t size = raster.occupied.size();
  const auto bands = static_cast<std::size_t>(std::max(jobs, 1));
  parallel_for(jobs, jobs, [&](int band) {
    const std::size_t begin = size * static_cast<std::size_t>(band) / bands;
    const std::size_t end = size * static_cast<std::size_t>(band + 1) / bands;
    for (std::size_t i = 0; i < raster.pixels.size(); ++i) {
      const std::size_t pixel = raster.pixels[i];
      if (pixel >= begin && pixel < end) visit(i, pixel);
    }
  });
}

/// Fills `raster` anew, for another focal length.
void project(const Tangents& tangents, double focal, int jobs, Raster& raster) {
  raster.camera = frame_of(tangents, focal);
  raster.pixels.resize(tangents.points.size());
  const auto f = static_cast<float>(raster.camera.fx);
  const auto cx = static_cast<float>(raster.camera.cx + 0.5);
  const auto cy = static_cast<float>(raster.camera.cy + 0.5);
  const auto width = static_cast<std::uint32_t>(raster.camera.width);
  const auto height = static_cast<std::uint32_t>(raster.camera.height);
  const auto size = static_cast<int>(raster.pixels.size());
  parallel_chunks(size, kChunk, jobs, [&](int, int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Eigen::Vector3f& tangent = tangents.points[i];
      const auto u = std::min(static_cast<std::uint32_t>(f * tangent.x() + cx), width - 1);
      const auto v = std::min(static_cast<std::uint32_t>(f * tangent.y() + cy), height - 1);
      raster.pixels[i] = v * width + u;
    }
  });
  raster.occupied.assign(static_cast<std::size_t>(width) * height, 0);
  for_points_by_pixel(raster, jobs,
                      [&](std::size_t, std::size_t pixel) { raster.occupied[pixel] = 1; });
}

/// How many of the eight pixels around an occupied one are occupied, as a share.
double filled_share(const Raster& raster, int jobs) {
  const auto width = static_cast<std::ptrdiff_t>(raster.camera.width);
  std::atomic<long> filled{0};
  std::atomic<long> centres{0};
  parallel_chunks(raster.camera.height - 2, kRowsPerChunk, jobs, [&](int, int begin, int end) {
    long filled_here = 0;
    long centres_here = 0;
    for (std::ptrdiff_t v = 1 + begin; v < 1 + end; ++v) {
      for (std::ptrdiff_t u = 1; u + 1 < width; ++u) {
        const std::uint8_t* centre = raster.occupied.data() + v * width + u;
        if (*centre == 0) continue;
        ++centres_here;
        for (const std::ptrdiff_t row : {-width, std::ptrdiff_t{0}, width}) {
          filled_here += centre[row - 1] + centre[row] + centre[row + 1];
        }
      }
    }
    filled += filled_here;
    centres += centres_here;
  });
  return centres > 0 ? static_cast<double>(filled - centres) / static_cast<double>(8 * centres)
                     : 1.0;
}

/// The points as a camera of suitable focal length sees them.
Raster choose_camera(const Tangents& tangents, int jobs) {
  constexpr int kSteps = 4;
  constexpr double kNearEnough = 0.06;
  constexpr double kLeastFilled = 0.7;
  const double extent = std::max(static_cast<double>(tangents.box.sizes().maxCoeff()), 1e-6);
  const double finest = kMostPixelsPerSide / extent;
  const auto points = static_cast<double>(tangents.points.size());
  double focal = std::min(finest, std::sqrt(points) / extent);
  Raster raster;
  project(tangents, focal, jobs, raster);
  for (int i = 0; i < kSteps; ++i) {
    const double density = raster.points_per_occupied_pixel() / kPointsPerPixel;
    const double better = std::min(finest, focal * std::sqrt(density));
    if (std::abs(better - focal) < 0.5 * kNearEnough * focal) break;
    focal = better;
    project(tangents, focal, jobs, raster);
  }
  // Points crowd along the lines of some scanners and the creases of meshes: pixels must be so
  // large that the gaps between them close, too.
  for (int i = 0; i < kSteps; ++i) {
    const double filled = std::max(filled_share(raster, jobs), 0.05);
    if (filled >= kLeastFilled) break;
    focal *= 0.97 * std::sqrt(std::log1p(-filled) / std::log1p(-kLeastFilled));
    project(tangents, focal, jobs, raster);
  }
  return raster;
}

/// The least of the positive depths within `reach` pixels of each, in a square; infinite where
/// there is none.
std::vector<float> nearest_around(const std::vector<float>& depth, int width, int height, int reach,
                                  int jobs) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  const auto padded_width = static_cast<std::size_t>(width + 2 * reach);
  std::vector<float> nearest(depth.size());
  parallel_chunks(height, kRowsPerChunk, jobs, [&](int, int begin, int end) {
    std::vector<float> column(padded_width);  // least of the rows, at each u
    for (int v = begin; v < end; ++v) {
      std::fill(column.begin(), column.end(), kNone);
      for (int k = std::max(v - reach, 0); k <= std::min(v + reach, height - 1); ++k) {
        const float* row = depth.data() + std::ptrdiff_t{k} * width;
        float* least = column.data() + reach;
        for (int u = 0; u < width; ++u)
          least[u] = std::min(least[u], row[u] > 0.0f ? row[u] : kNone);
      }
      float* out = nearest.data() + std::ptrdiff_t{v} * width;
      std::fill(out, out + width, kNone);
      for (int k = 0; k <= 2 * reach; ++k) {
        const float* shifted = column.data() + k;
        for (int u = 0; u < width; ++u) out[u] = std::min(out[u], shifted[u]);
      }
    }
  });
  return nearest;
}

/// Takes away what is seen between the points of a nearer surface: pixels with much nearer ones
/// close by on opposite sides, along at least two of four lines. Across a silhouette there are none
/// on the far side.
void remove_seen_through(RangeImage& image, int jobs) {
  constexpr int kReach = 3;              // pixels: wider gaps are rare in a closed surface
  constexpr float kNearerPixels = 8.0f;  // pixel widths in depth: more than a steep surface falls
  constexpr std::array<std::array<int, 2>, 4> kLines = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  const int width = image.intrinsics.width;
  const int height = image.intrinsics.height;
  const std::vector<float> depth = image.depth;
  const float step = kNearerPixels / static_cast<float>(image.intrinsics.fx);
  const auto is_nearer = [&](int u, int v, float z) {
    if (u < 0 || v < 0 || u >= width || v >= height) return false;
    const float other = depth[static_cast<std::size_t>(v * width + u)];
    return other > 0.0f && other < z - step * z;
  };
  const auto is_seen_through = [&](int u, int v, float z) {
    int lines = 0;
    for (const auto& [du, dv] : kLines) {
      bool before = false, after = false;
      for (int k = 1; k <= kReach; ++k) {
        before = before || is_nearer(u - k * du, v - k * dv, z);
        after = after || is_nearer(u + k * du, v + k * dv, z);
      }
      lines += before && after ? 1 : 0;
    }
    return lines >= 2;
  };
  const std::vector<float> nearest = nearest_around(depth, width, height, kReach, jobs);
  const auto size = static_cast<int>(depth.size());
  parallel_chunks(size, kChunk, jobs, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto index = static_cast<std::size_t>(i);
      const float z = depth[index];
      // Nearly nowhere is anything near enough: the lines need not be walked.
      if (z > 0.0f && nearest[index] < z - step * z && is_seen_through(i % width, i / width, z)) {
        image.depth[index] = 0.0f;
      }
    }
  });
}

RangeImage depths_of(const Tangents& tangents, const Raster& raster, int jobs) {
  RangeImage image;
  image.intrinsics = raster.camera;
  const std::size_t size = raster.occupied.size();
  std::vector<float> nearest(size, std::numeric_limits<float>::infinity());
  for_points_by_pixel(raster, jobs, [&](std::size_t i, std::size_t pixel) {
    nearest[pixel] = std::min(nearest[pixel], tangents.points[i].z());
  });
  std::vector<float> count(size, 0.0f);
  image.depth.assign(size, 0.0f);
  for_points_by_pixel(raster, jobs, [&](std::size_t i, std::size_t pixel) {
    const float z = tangents.points[i].z();
    if (z > kSameSurface * nearest[pixel]) return;
    image.depth[pixel] += z;
    count[pixel] += 1.0f;
  });
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] > 0.0f) image.depth[i] /= count[i];
  }
  remove_seen_through(image, jobs);
  return image;
}

}  // namespace

ProjectedCloud project_cloud(const PointCloud& cloud, const Eigen::Vector3d& viewpoint, int jobs) {
  if (auto kept = keep_pixels(cloud, viewpoint, jobs)) return std::move(*kept);
  ProjectedCloud projected;
  projected.T_cloud_camera.translation() = viewpoint;
  const std::optional<Eigen::Vector3d> middle = mean_of(cloud.points, jobs);
  if (!middle || !((*middle - viewpoint).norm() > 0.0)) return projected;
  projected.T_cloud_camera = looking_at(viewpoint, *middle);
  const Tangents tangents = tangents_of(cloud.points, projected.T_cloud_camera, jobs);
  if (tangents.points.empty()) return projected;
  projected.image = depths_of(tangents, choose_camera(tangents, jobs), jobs);
  return projected;
}

}  // namespace binpick
