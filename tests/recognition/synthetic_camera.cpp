#include "recognition/synthetic_camera.h"

#include <algorithm>
#include <cmath>

namespace binpick::testing {
namespace {

constexpr float kNearest = 0.05f;  // triangles that come closer are not drawn, m

}  // namespace

SyntheticCamera::SyntheticCamera(const CameraIntrinsics& intrinsics,
                                 const Eigen::Isometry3d& T_world_camera) {
  frame_.image.intrinsics = intrinsics;
  frame_.image.T_world_camera = T_world_camera;
  const auto size =
      static_cast<std::size_t>(intrinsics.width) * static_cast<std::size_t>(intrinsics.height);
  frame_.image.depth.assign(size, 0.0f);
  frame_.cosine.assign(size, 0.0f);
  frame_.owner.assign(size, CleanFrame::kGround);
  drawn_.assign(size, 0);
}

Coverage SyntheticCamera::draw(const Shape& shape, const Eigen::Isometry3d& T_world_shape,
                               std::int16_t owner) {
  const CameraIntrinsics& camera = frame_.image.intrinsics;
  const Eigen::Isometry3f T = (frame_.image.T_world_camera.inverse() * T_world_shape).cast<float>();
  ++shapes_;
  covered_ = 0;
  corners_.clear();
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector3f& vertex : shape.vertices) {
    const Eigen::Vector3f p = T * vertex;
    const float inverse = p.z() > kNearest ? 1.0f / p.z() : 0.0f;
    corners_.push_back({p, static_cast<float>(camera.fx) * p.x() * inverse + float(camera.cx),
                        static_cast<float>(camera.fy) * p.y() * inverse + float(camera.cy),
                        inverse});
    box.extend(Eigen::Vector2f(corners_.back().u, corners_.back().v));
  }
  for (const auto& t : shape.triangles) {
    const Corner& a = corners_[static_cast<std::size_t>(t[0])];
    const Corner& b = corners_[static_cast<std::size_t>(t[1])];
    const Corner& c = corners_[static_cast<std::size_t>(t[2])];
    if (a.inverse_z > 0.0f && b.inverse_z > 0.0f && c.inverse_z > 0.0f) {
      draw_triangle(a, b, c, owner);
    }
  }
  const bool in_frame = box.min().x() > 0.5f && box.min().y() > 0.5f &&
                        box.max().x() < static_cast<float>(camera.width) - 1.5f &&
                        box.max().y() < static_cast<float>(camera.height) - 1.5f;
  return {covered_, in_frame};
}

void SyntheticCamera::draw_triangle(const Corner& a, const Corner& b, const Corner& c,
                                    std::int16_t owner) {
  const CameraIntrinsics& camera = frame_.image.intrinsics;
  const float area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
  if (area == 0.0f) return;
  const auto first = [](float x, float y, float z) {
    return std::max(static_cast<int>(std::ceil(std::min({x, y, z}))), 0);
  };
  const auto last = [](float x, float y, float z, int size) {
    return std::min(static_cast<int>(std::floor(std::max({x, y, z}))), size - 1);
  };
  const Eigen::Vector3f normal = (b.p - a.p).cross(c.p - a.p).normalized();
  const int last_u = last(a.u, b.u, c.u, camera.width);
  const int last_v = last(a.v, b.v, c.v, camera.height);
  for (int v = first(a.v, b.v, c.v); v <= last_v; ++v) {
    for (int u = first(a.u, b.u, c.u); u <= last_u; ++u) {
      const auto pu = static_cast<float>(u);
      const auto pv = static_cast<float>(v);
      const float wa = ((b.u - pu) * (c.v - pv) - (b.v - pv) * (c.u - pu)) / area;
      const float wb = ((c.u - pu) * (a.v - pv) - (c.v - pv) * (a.u - pu)) / area;
      const float wc = 1.0f - wa - wb;
      if (wa < 0.0f || wb < 0.0f || wc < 0.0f) continue;
      const float z = 1.0f / (wa * a.inverse_z + wb * b.inverse_z + wc * c.inverse_z);
      const auto pixel = static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) +
                         static_cast<std::size_t>(u);
      if (drawn_[pixel] != shapes_) {
        drawn_[pixel] = shapes_;
        ++covered_;
      }
      float& nearest = frame_.image.depth[pixel];
      if (nearest > 0.0f && nearest <= z) continue;
      nearest = z;
      frame_.owner[pixel] = owner;
      const Eigen::Vector3f ray((pu - static_cast<float>(camera.cx)) / float(camera.fx),
                                (pv - static_cast<float>(camera.cy)) / float(camera.fy), 1.0f);
      frame_.cosine[pixel] = std::abs(normal.dot(ray)) / ray.norm();
    }
  }
}

}  // namespace binpick::testing
