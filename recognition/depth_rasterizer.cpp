#include "recognition/depth_rasterizer.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr float kNearest = 0.01f;  // triangles that come closer to the sensor are not drawn, m

/// Twice the signed area of (a, b, c) in the image.
float doubled_area(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

void draw(RenderedModel& window, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
          const Eigen::Vector3f& c, std::int32_t triangle) {
  const float area = doubled_area(a, b, c);
  // Corners that run counter-clockwise for a viewer outside give a negative area here: v points
  // down.
  if (!(area < 0.0f)) return;
  const auto low = [](float x, float y, float z) {
    return static_cast<int>(std::ceil(std::min({x, y, z})));
  };
  const auto high = [](float x, float y, float z) {
    return static_cast<int>(std::floor(std::max({x, y, z})));
  };
  const int first_u = std::max(low(a.x(), b.x(), c.x()), window.u0);
  const int last_u = std::min(high(a.x(), b.x(), c.x()), window.u0 + window.width - 1);
  const int first_v = std::max(low(a.y(), b.y(), c.y()), window.v0);
  const int last_v = std::min(high(a.y(), b.y(), c.y()), window.v0 + window.height - 1);
  const float inverse_area = 1.0f / area;
  for (int v = first_v; v <= last_v; ++v) {
    for (int u = first_u; u <= last_u; ++u) {
      const Eigen::Vector3f p(static_cast<float>(u), static_cast<float>(v), 0.0f);
      const float wa = doubled_area(b, c, p) * inverse_area;
      const float wb = doubled_area(c, a, p) * inverse_area;
      const float wc = 1.0f - wa - wb;
      if (wa < 0.0f || wb < 0.0f || wc < 0.0f) continue;
      // 1 / z is linear in the image.
      const float z = 1.0f / (wa * a.z() + wb * b.z() + wc * c.z());
      const std::size_t index = window.index(u - window.u0, v - window.v0);
      if (window.depth[index] > 0.0f && window.depth[index] <= z) continue;
      window.depth[index] = z;
      window.triangle[index] = triangle;
    }
  }
}

}  // namespace

const RenderedModel& DepthRasterizer::render(const RenderMesh& mesh,
                                             const Eigen::Isometry3f& T_camera_model,
                                             const Projection& projection) {
  projected_.clear();
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3f p = T_camera_model * vertex;
    const float inverse = p.z() > kNearest ? 1.0f / p.z() : 0.0f;
    projected_.emplace_back(projection.fx * p.x() * inverse + projection.cx,
                            projection.fy * p.y() * inverse + projection.cy, inverse);
    if (inverse > 0.0f) box.extend(projected_.back().head<2>());
  }
  const auto bound = [](float value, int size) {
    return static_cast<int>(std::clamp(value, -1.0f, static_cast<float>(size)));
  };
  rendered_.u0 = std::max(bound(box.min().x(), projection.width), 0);
  rendered_.v0 = std::max(bound(box.min().y(), projection.height), 0);
  const int end_u = std::min(bound(box.max().x(), projection.width) + 1, projection.width);
  const int end_v = std::min(bound(box.max().y(), projection.height) + 1, projection.height);
  rendered_.width = std::max(end_u - rendered_.u0, 0);
  rendered_.height = std::max(end_v - rendered_.v0, 0);
  const auto size =
      static_cast<std::size_t>(rendered_.width) * static_cast<std::size_t>(rendered_.height);
  rendered_.depth.assign(size, 0.0f);
  rendered_.triangle.assign(size, -1);
  if (size == 0) return rendered_;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto corner = [&](std::size_t k) -> const Eigen::Vector3f& {
      return projected_[static_cast<std::size_t>(mesh.triangles[i][k])];
    };
    if (!(corner(0).z() > 0.0f) || !(corner(1).z() > 0.0f) || !(corner(2).z() > 0.0f)) continue;
    draw(rendered_, corner(0), corner(1), corner(2), static_cast<std::int32_t>(i));
  }
  return rendered_;
}

}  // namespace binpick
