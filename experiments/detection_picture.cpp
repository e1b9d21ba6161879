#include "experiments/detection_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "recognition/cloud_projection.h"
#include "recognition/depth_rasterizer.h"

namespace binpick {
namespace {

using Colour = std::array<std::uint8_t, 3>;

constexpr std::array<Colour, 6> kColours{{{255, 90, 60},
                                          {70, 200, 255},
                                          {120, 230, 90},
                                          {255, 200, 40},
                                          {230, 110, 255},
                                          {60, 240, 200}}};
constexpr int kSmallestWidth = 480;  // smaller scans are drawn with larger pixels

/// Grey by the rank of the depth: a far wall does not flatten what lies near.
std::vector<std::uint8_t> greys(const RangeImage& image) {
  std::vector<float> sorted;
  std::copy_if(image.depth.begin(), image.depth.end(), std::back_inserter(sorted),
               [](float z) { return z > 0.0f; });
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint8_t> grey(image.depth.size(), 0);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    if (!(image.depth[i] > 0.0f)) continue;
    const auto rank = std::lower_bound(sorted.begin(), sorted.end(), image.depth[i]);
    const double share =
        static_cast<double>(rank - sorted.begin()) / static_cast<double>(sorted.size());
    grey[i] = static_cast<std::uint8_t>(std::lround(200.0 - 160.0 * share));
  }
  return grey;
}

void set_pixel(ColourImage& image, int u, int v, const Colour& colour) {
  std::copy(colour.begin(), colour.end(),
            image.rgb.begin() + 3 * (std::ptrdiff_t{v} * image.width + u));
}

void draw_outline(const RenderedModel& model, const Colour& colour, int scale, ColourImage& image) {
  for (int v = 0; v < model.height; ++v) {
    for (int u = 0; u < model.width; ++u) {
      const bool inside = model.covers(u - 1, v) && model.covers(u + 1, v) &&
                          model.covers(u, v - 1) && model.covers(u, v + 1);
      if (!model.covers(u, v) || inside) continue;
      for (int dv = 0; dv < scale; ++dv) {
        for (int du = 0; du < scale; ++du) {
          set_pixel(image, scale * (model.u0 + u) + du, scale * (model.v0 + v) + dv, colour);
        }
      }
    }
  }
}

}  // namespace

ColourImage detection_picture(const PointCloud& scan, const Eigen::Vector3d& viewpoint,
                              const std::vector<Detection>& detections,
                              const ModelLibrary& library) {
  const ProjectedCloud view = project_cloud(scan, viewpoint);
  const CameraIntrinsics& camera = view.image.intrinsics;
  if (camera.width == 0 || camera.height == 0) return {};
  const int scale = (kSmallestWidth + camera.width - 1) / camera.width;
  ColourImage image{scale * camera.width, scale * camera.height, {}};
  image.rgb.resize(std::size_t{3} * static_cast<std::size_t>(image.width) *
                   static_cast<std::size_t>(image.height));
  const std::vector<std::uint8_t> grey = greys(view.image);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const std::uint8_t shade =
          grey[static_cast<std::size_t>(v / scale) * static_cast<std::size_t>(camera.width) +
               static_cast<std::size_t>(u / scale)];
      set_pixel(image, u, v, {shade, shade, shade});
    }
  }
  const Projection projection = projection_of(camera);
  const Eigen::Isometry3d T_camera_scene = view.T_cloud_camera.inverse();
  DepthRasterizer rasterizer;
  for (const Detection& detection : detections) {
    const auto& models = library.models();
    const auto model = std::find_if(models.begin(), models.end(), [&](const auto& candidate) {
      return candidate.name == detection.model;
    });
    if (model == models.end()) continue;
    const Eigen::Isometry3d T_camera_model = T_camera_scene * detection.T_scene_model;
    const auto index = static_cast<std::size_t>(model - models.begin());
    draw_outline(rasterizer.render(model->render_mesh, T_camera_model.cast<float>(), projection),
                 kColours[index % kColours.size()], scale, image);
  }
  return image;
}

}  // namespace binpick
