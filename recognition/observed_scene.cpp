#include "recognition/observed_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "recognition/parallel_for.h"
#include "recognition/stopwatch.h"

namespace binpick {
namespace {

constexpr float kSameSurface = 1.015f;   // depths within 1.5 % of the nearest are averaged
constexpr double kPixelsPerLeaf = 1.35;  // a working pixel must not be coarser than a leaf / this
constexpr int kLeavesPerChunk = 8192;
constexpr int kFitsPerChunk = 128;
constexpr int kRowsPerChunk = 16;
constexpr int kMostLeaves = 400000;  // keeps a scene of any size affordable, at a coarser leaf

double median_depth(const RangeImage& image) {
  std::vector<float> depths;
  for (std::size_t i = 0; i < image.depth.size(); i += 7) {
    if (image.depth[i] > 0.0f && std::isfinite(image.depth[i])) depths.push_back(image.depth[i]);
  }
  if (depths.empty()) return 0.0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return static_cast<double>(*middle);
}

/// The points of the pixels [begin, end), not a number where nothing was measured.
void write_points(const RangeImage& image, std::size_t begin, std::size_t end,
                  Eigen::Vector3f* points) {
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  const CameraIntrinsics& camera = image.intrinsics;
  const auto ifx = static_cast<float>(1.0 / camera.fx);
  const auto ify = static_cast<float>(1.0 / camera.fy);
  const auto width = static_cast<std::size_t>(camera.width);
  std::size_t u = begin % width;
  std::size_t v = begin / width;
  for (std::size_t i = begin; i < end; ++i) {
    const float z = image.depth[i] > 0.0f ? image.depth[i] : kNothing;
    points[i - begin] = {(static_cast<float>(u) - static_cast<float>(camera.cx)) * ifx * z,
                         (static_cast<float>(v) - static_cast<float>(camera.cy)) * ify * z, z};
    if (++u == width) {
      u = 0;
      ++v;
    }
  }
}

/// The mean of the depths of a block that belong to its nearest surface.
float depth_of_block(const RangeImage& image, int u0, int v0, int block) {
  float nearest = 0.0f;
  for (int v = v0; v < v0 + block; ++v) {
    for (int u = u0; u < u0 + block; ++u) {
      const float z = image.at(u, v);
      if (z > 0.0f && std::isfinite(z) && (nearest == 0.0f || z < nearest)) nearest = z;
    }
  }
  if (block == 1 || nearest == 0.0f) return nearest;
  float sum = 0.0f;
  float count = 0.0f;
  for (int v = v0; v < v0 + block; ++v) {
    for (int u = u0; u < u0 + block; ++u) {
      const float z = image.at(u, v);
      if (!(z > 0.0f) || z > kSameSurface * nearest) continue;
      sum += z;
      count += 1.0f;
    }
  }
  return sum / count;
}

std::int8_t rounded(float value) {
  return static_cast<std::int8_t>(value < 0.0f ? value - 0.5f : value + 0.5f);
}

}  // namespace

Projection projection_of(const CameraIntrinsics& camera, int block) {
  Projection p;
  p.width = camera.width / block;
  p.height = camera.height / block;
  p.fx = static_cast<float>(camera.fx / block);
  p.fy = static_cast<float>(camera.fy / block);
  p.cx = static_cast<float>((camera.cx - 0.5 * (block - 1)) / block);
  p.cy = static_cast<float>((camera.cy - 0.5 * (block - 1)) / block);
  return p;
}

double point_spacing(const RangeImage& image) {
  return median_depth(image) / std::max(image.intrinsics.fx, 1e-9);
}

ObservedScene::ObservedScene(const RangeImage& image, const SceneScale& scale, int jobs, Seed seed)
    : octree_(std::vector<Eigen::Vector3f>{}, 1.0f) {
  Stopwatch watch;
  const double spacing = point_spacing(image);
  const auto leaf_size = static_cast<float>(std::max(scale.leaf_size, 2.0 * spacing));
  int block = 1;
  while ((block + 1) * spacing * kPixelsPerLeaf <= static_cast<double>(leaf_size)) {
    ++block;
  }
  projection_ = projection_of(image.intrinsics, block);
  const auto width = static_cast<std::size_t>(projection_.width);
  pixels_.resize(width * static_cast<std::size_t>(projection_.height));
  parallel_chunks(projection_.height, kRowsPerChunk, jobs, [&](int, int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const std::size_t row = static_cast<std::size_t>(v) * width;
      for (int u = 0; u < projection_.width; ++u) {
        pixels_[row + static_cast<std::size_t>(u)].depth =
            depth_of_block(image, u * block, v * block, block);
      }
    }
  });
  timings_.image = watch.lap();

  const SceneOctree::PointSource points = [&](std::size_t begin, std::size_t end,
                                              Eigen::Vector3f* out) {
    write_points(image, begin, end, out);
  };
  octree_ = SceneOctree(image.depth.size(), points, leaf_size, jobs);
  while (octree_.size() > kMostLeaves) {
    const float excess = static_cast<float>(octree_.size()) / static_cast<float>(kMostLeaves);
    const float coarser = 1.05f * std::sqrt(excess) * octree_.leaf_size();
    octree_ = SceneOctree(image.depth.size(), points, coarser, jobs);
  }
  timings_.octree = watch.lap();

  SupportPlaneOptions options;
  options.least_area = scale.least_plane_area;
  // Much of either runs on one thread, and they have nothing to do with each other.
  parallel_for(2, jobs, [&](int task) {
    if (task == 0) planes_ = find_support_planes(octree_, options, seed, jobs);
    if (task == 1) sensor_ = estimate_sensor(projection_, pixels_, jobs);
  });
  mark_support(jobs);
  timings_.planes = watch.lap();

  estimate_normals(jobs);
  // Too few usable pixels: the patches' noise is the best that is known.
  if (sensor_.axial_variance(1.0f) == 0.0f) sensor_.constant = noise_;
  fill_pixels(jobs);
  searched_pixels_ = pixels_;
  for (const int leaf : object_leaves_) pixel_of_object_leaf_.push_back(pixel_of_leaf(leaf));
  is_open_.assign(on_support_.size(), 0);
  for (const int leaf : object_leaves_) is_open_[static_cast<std::size_t>(leaf)] = 1;
  timings_.normals = watch.lap();
}

void ObservedScene::mark_support(int jobs) {
  on_support_.assign(static_cast<std::size_t>(octree_.size()), 0);
  for (const SupportPlane& plane : planes_) {
    const PlaneHeight height(plane);
    const auto tolerance = static_cast<float>(plane.tolerance);
    parallel_chunks(octree_.size(), kLeavesPerChunk, jobs, [&](int, int begin, int end) {
      for (auto leaf = static_cast<std::size_t>(begin); leaf < static_cast<std::size_t>(end);
           ++leaf) {
        const Eigen::Vector3f& p = octree_.points()[leaf];
        if (height(p.x(), p.y(), p.z()) < tolerance) on_support_[leaf] = 1;
      }
    });
  }
  for (int leaf = 0; leaf < octree_.size(); ++leaf) {
    if (!on_support(leaf)) object_leaves_.push_back(leaf);
  }
}

void ObservedScene::estimate_normals(int jobs) {
  const auto size = static_cast<std::size_t>(octree_.size());
  normals_.assign(size, Eigen::Vector3f::Zero());
  reliable_.assign(size, 0);
  std::vector<LocalPlane> fits(object_leaves_.size());
  parallel_chunks(static_cast<int>(fits.size()), kFitsPerChunk, jobs, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      fits[static_cast<std::size_t>(i)] =
          octree_.plane_at(object_leaves_[static_cast<std::size_t>(i)]);
    }
  });
  constexpr int kLeastPoints = 8;
  std::vector<float> deviations;
  for (const LocalPlane& fit : fits) {
    if (fit.points >= kLeastPoints) deviations.push_back(fit.deviation);
  }
  if (!deviations.empty()) {
    // A low percentile: patches across edges and on curved parts deviate for other reasons.
    const auto rank = deviations.begin() + static_cast<std::ptrdiff_t>(3 * deviations.size() / 10);
    std::nth_element(deviations.begin(), rank, deviations.end());
    noise_ = *rank;
  }
  const float leaf_size = octree_.leaf_size();
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const auto leaf = static_cast<std::size_t>(object_leaves_[i]);
    const LocalPlane& fit = fits[i];
    normals_[leaf] = fit.normal.dot(octree_.points()[leaf]) > 0.0f ? -fit.normal : fit.normal;
    const bool reliable = fit.points >= kLeastPoints && fit.width > 0.25f * leaf_size &&
                          fit.deviation < std::max(2.0f * noise_, 0.2f * fit.width);
    reliable_[leaf] = reliable ? 1 : 0;
  }
}

void ObservedScene::fill_pixels(int jobs) {
  leaf_of_pixel_.assign(pixels_.size(), -1);
  parallel_chunks(projection_.height, kRowsPerChunk, jobs, [&](int, int begin, int end) {
    auto i = static_cast<std::size_t>(begin) * static_cast<std::size_t>(projection_.width);
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < projection_.width; ++u, ++i) {
        ScenePixel& pixel = pixels_[i];
        if (!(pixel.depth > 0.0f)) continue;
        const int leaf = octree_.leaf_at(projection_.point(u, v, pixel.depth));
        leaf_of_pixel_[i] = leaf;
        if (leaf < 0) continue;
        if (on_support(leaf)) {
          pixel.flags = ScenePixel::kSupport;
          continue;
        }
        const Eigen::Vector3f n = 127.0f * normal(leaf);
        pixel.nx = rounded(n.x());
        pixel.ny = rounded(n.y());
        pixel.nz = rounded(n.z());
        if (normal_is_reliable(leaf)) pixel.flags = ScenePixel::kNormal;
      }
    }
  });
}

/// The pixel that sees a leaf's points, or -1 where it sees what is before or behind them.
int ObservedScene::pixel_of_leaf(int leaf) const {
  const Eigen::Vector3f& p = octree_.point(leaf);
  const int index = projection_.pixel(p);
  if (index < 0) return -1;
  return std::abs(pixel(index).depth - p.z()) < 2.0f * octree_.leaf_size() ? index : -1;
}

void ObservedScene::set_explained(const std::vector<int>& pixels) {
  for (const int index : explained_) {
    const auto i = static_cast<std::size_t>(index);
    searched_pixels_[i] = pixels_[i];
  }
  for (const int leaf : object_leaves_) is_open_[static_cast<std::size_t>(leaf)] = 1;
  explained_ = pixels;
  for (const int index : explained_) {
    const auto i = static_cast<std::size_t>(index);
    searched_pixels_[i].flags |= ScenePixel::kSupport;
    if (leaf_of_pixel_[i] >= 0) is_open_[static_cast<std::size_t>(leaf_of_pixel_[i])] = 0;
  }
  // A third of the leaves of a surface have none of its pixels in them, which are hardly finer.
  for (std::size_t i = 0; i < object_leaves_.size(); ++i) {
    if (pixel_of_object_leaf_[i] < 0) continue;
    const auto pixel = static_cast<std::size_t>(pixel_of_object_leaf_[i]);
    if (searched_pixels_[pixel].flags != pixels_[pixel].flags) {
      is_open_[static_cast<std::size_t>(object_leaves_[i])] = 0;
    }
  }
}

}  // namespace binpick
