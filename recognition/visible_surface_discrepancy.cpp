#include "recognition/visible_surface_discrepancy.h"

#include <cmath>
#include <vector>

#include "recognition/depth_rasterizer.h"

namespace binpick {
namespace {

/// Distances from the sensor (not z), 0 where there is no surface.
std::vector<double> distances(const RenderMesh& mesh, const Eigen::Isometry3d& T_camera_model,
                              const Projection& projection) {
  std::vector<double> all(static_cast<std::size_t>(projection.width) *
                          static_cast<std::size_t>(projection.height));
  DepthRasterizer rasterizer;
  const RenderedModel& rendered = rasterizer.render(mesh, T_camera_model.cast<float>(), projection);
  for (int v = 0; v < rendered.height; ++v) {
    for (int u = 0; u < rendered.width; ++u) {
      const int at_u = rendered.u0 + u;
      const int at_v = rendered.v0 + v;
      const float z = rendered.depth[rendered.index(u, v)];
      all[static_cast<std::size_t>(at_v * projection.width + at_u)] =
          static_cast<double>(projection.point(at_u, at_v, z).norm());
    }
  }
  return all;
}

}  // namespace

double visible_surface_discrepancy(const Eigen::Isometry3d& T_camera_estimated,
                                   const Eigen::Isometry3d& T_camera_true, const RenderMesh& mesh,
                                   std::span<const float> depth, const Projection& projection,
                                   const DiscrepancyOptions& options) {
  const std::vector<double> estimated = distances(mesh, T_camera_estimated, projection);
  const std::vector<double> truth = distances(mesh, T_camera_true, projection);
  int either = 0;
  int differing = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!(estimated[i] > 0.0) && !(truth[i] > 0.0)) continue;
    const double seen = static_cast<double>(
        projection.point(static_cast<int>(i), depth[i] > 0.0f ? depth[i] : 0.0f).norm());
    const auto shows = [&](double distance) {
      return distance > 0.0 && (seen == 0.0 || distance - seen <= options.visibility_margin);
    };
    const bool is_visible_true = shows(truth[i]);
    // Where the true surface is visible, the estimated one is not excused by what is in front.
    const bool is_visible_estimated =
        shows(estimated[i]) || (is_visible_true && estimated[i] > 0.0);
    if (!is_visible_true && !is_visible_estimated) continue;
    ++either;
    if (!is_visible_true || !is_visible_estimated ||
        std::abs(truth[i] - estimated[i]) >= options.tolerance) {
      ++differing;
    }
  }
  return either > 0 ? static_cast<double>(differing) / either : 1.0;
}

}  // namespace binpick
