#include "experiments/recognition_sensor.h"

#include <algorithm>
#include <cmath>

#include "sim/laser_scanner.h"
#include "sim/structured_light.h"

namespace binpick {
namespace {

/// Relative depth step that separates two surfaces, as in StructuredLightOptions.
constexpr float kStep = 0.02f;

/// One pass along rows (stride 1) or columns: each pixel takes the nearest depth within `reach` on
/// its line if that belongs to a nearer surface.
void dilate_lines(std::vector<float>& depth, int lines, int length, std::size_t line_stride,
                  std::size_t stride, int reach) {
  std::vector<float> line(static_cast<std::size_t>(length));
  for (int l = 0; l < lines; ++l) {
    float* first = depth.data() + static_cast<std::size_t>(l) * line_stride;
    for (int i = 0; i < length; ++i) line[std::size_t(i)] = first[std::size_t(i) * stride];
    for (int i = 0; i < length; ++i) {
      float nearest = line[std::size_t(i)];
      for (int k = std::max(0, i - reach); k <= std::min(length - 1, i + reach); ++k) {
        const float other = line[std::size_t(k)];
        if (other > 0.0f && other < (1.0f - kStep) * nearest) nearest = other;
      }
      first[std::size_t(i) * stride] = nearest;
    }
  }
}

RangeImage kinect(RangeImage image, const RecognitionConditions& conditions, Seed seed) {
  StructuredLightOptions options;
  options.axial_noise *= conditions.noise;
  options.bow = conditions.noise * conditions.bow;
  apply_structured_light(image, options, seed);
  return image;
}

RangeImage laser(RangeImage image, const RecognitionConditions& conditions, Seed seed) {
  LaserScannerOptions options;
  options.axial_noise *= conditions.noise;
  apply_laser_scanner(image, options, seed);
  return image;
}

PointCloud noisy_cloud(const RangeImage& ideal, double sigma, Seed seed) {
  PointCloud cloud;
  for (std::size_t i = 0; i < ideal.depth.size(); ++i) {
    if (ideal.depth[i] > 0.0f) {
      cloud.points.push_back(gaussian_point(ideal, i, sigma, seed).cast<float>());
    }
  }
  cloud.width = static_cast<int>(cloud.points.size());
  cloud.height = 1;
  return cloud;
}

}  // namespace

void dilate_silhouettes(RangeImage& image, int pixels) {
  if (pixels <= 0) return;
  const int width = image.intrinsics.width;
  const int height = image.intrinsics.height;
  dilate_lines(image.depth, height, width, std::size_t(width), 1, pixels);
  dilate_lines(image.depth, width, height, 1, std::size_t(width), pixels);
}

Eigen::Vector3d gaussian_point(const RangeImage& ideal, std::size_t i, double sigma, Seed seed) {
  const auto width = static_cast<std::size_t>(ideal.intrinsics.width);
  const Eigen::Vector3d p =
      ideal.p_camera(static_cast<int>(i % width), static_cast<int>(i / width));
  Random draw(seed, 6 * std::uint64_t{i});
  const double x = draw.normal();
  const double y = draw.normal();
  const double z = draw.normal();
  return p + sigma * Eigen::Vector3d(x, y, z);
}

Scan measure(const RangeImage& ideal, const RecognitionConditions& conditions, double diagonal,
             Seed seed) {
  RangeImage image = ideal;
  dilate_silhouettes(image, static_cast<int>(conditions.dilation));
  if (conditions.sensor == "kinect") return kinect(std::move(image), conditions, seed);
  if (conditions.sensor == "laser") return laser(std::move(image), conditions, seed);
  if (conditions.sensor == "gaussian") {
    return noisy_cloud(image, conditions.gaussian * diagonal, seed);
  }
  return image;
}

RangeImage lit(const RangeImage& ideal, const RecognitionConditions& conditions) {
  RangeImage image = ideal;
  if (conditions.sensor == "kinect") {
    StructuredLightOptions options;
    options.disparity_step = options.axial_noise = 0.0;
    options.edge_raggedness = options.edge_dropout = 0.0;
    options.grazing_limit_deg = 90.0;
    apply_structured_light(image, options, 0);
  } else if (conditions.sensor == "laser") {
    LaserScannerOptions options;
    options.axial_noise = options.edge_dropout = options.mixed_points = 0.0;
    options.grazing_limit_deg = 90.0;
    apply_laser_scanner(image, options, 0);
  }
  return image;
}

void keep_objects_only(RangeImage& scan, const SegmentationImage& owners) {
  for (std::size_t i = 0; i < scan.depth.size(); ++i) {
    if (owners.object[i] < 0) scan.depth[i] = 0.0f;
  }
}

std::size_t point_count(const Scan& scan) {
  if (const auto* cloud = std::get_if<PointCloud>(&scan)) return cloud->points.size();
  const std::vector<float>& depth = std::get<RangeImage>(scan).depth;
  return static_cast<std::size_t>(
      std::count_if(depth.begin(), depth.end(), [](float z) { return z > 0.0f; }));
}

}  // namespace binpick
