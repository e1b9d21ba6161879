#include "recognition/depth_rasterizer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace binpick {
namespace {

constexpr float kNearest = 0.01f;  // triangles that come closer to the sensor are not drawn, m
// Pixel centres this close to an edge belong to both of its triangles, so that rounding opens no
// crack between them.
constexpr float kEdgeSlack = 1e-4f;

// Four pixels of a row at a time; GCC and clang have these types for every processor.
constexpr int kLanes = 4;
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));
constexpr Ints kLaneIndices = {0, 1, 2, 3};

template <class Vector, class Scalar>
Vector load(const Scalar* from) {
  Vector vector;
  std::memcpy(&vector, from, sizeof(vector));
  return vector;
}
template <class Scalar, class Vector>
void store(Scalar* to, const Vector& vector) {
  std::memcpy(to, &vector, sizeof(vector));
}

/// A side of a triangle, by the half of each row of pixels that lies within it.
struct Edge {
  float slope = 0.0f;  // du / dv
  float u = 0.0f, v = 0.0f;
  enum { kLevel, kLeft, kRight } side = kLevel;

  /// From `a` to `b`; the inside lies where (b - a) x (p - a) is negative.
  Edge(const Eigen::Vector3f& a, const Eigen::Vector3f& b) : u(a.x()), v(a.y()) {
    const float rise = b.y() - a.y();
    if (rise == 0.0f) return;  // the rows between the corners bound the triangle there
    slope = (b.x() - a.x()) / rise;
    side = rise < 0.0f ? kRight : kLeft;
  }
};

/// The pixels [begin, end) of four rows whose centres lie within a triangle.
struct RowSpans {
  Floats rows;
  Ints begin;
  Ints end;  // not above `begin` where the triangle has none

  /// From row `v` on, within the columns [first_u, last_u] of the image.
  RowSpans(const std::array<Edge, 3>& edges, int v, float first_u, float last_u)
      : rows(__builtin_convertvector(v + kLaneIndices, Floats)) {
    Floats left = first_u + Floats{};
    Floats right = last_u + Floats{};
    for (const Edge& edge : edges) {
      const Floats u = edge.u + edge.slope * (rows - edge.v);
      const Floats from = u - kEdgeSlack;
      const Floats to = u + kEdgeSlack;
      if (edge.side == Edge::kLeft) left = left < from ? from : left;
      if (edge.side == Edge::kRight) right = to < right ? to : right;
    }
    // No column is negative, so that cutting off rounds down.
    const Ints is_empty = ~(left <= right);
    const Ints whole = __builtin_convertvector(left, Ints);
    begin = whole - (__builtin_convertvector(whole, Floats) < left);  // true is -1
    end = is_empty ? begin : __builtin_convertvector(right, Ints) + 1;
  }
};

}  // namespace

void DepthRasterizer::draw(const std::array<std::int32_t, 3>& corners, std::int32_t triangle) {
  const Eigen::Vector3f& a = projected_[static_cast<std::size_t>(corners[0])];
  const Eigen::Vector3f& b = projected_[static_cast<std::size_t>(corners[1])];
  const Eigen::Vector3f& c = projected_[static_cast<std::size_t>(corners[2])];
  if (!(a.z() > 0.0f && b.z() > 0.0f && c.z() > 0.0f)) return;
  // Corners that run counter-clockwise for a viewer outside give a negative area: v points down.
  const Eigen::Vector3f ab = b - a;
  const Eigen::Vector3f ac = c - a;
  const float doubled_area = ab.x() * ac.y() - ab.y() * ac.x();
  if (!(doubled_area < 0.0f)) return;
  const int first_v = std::max(
      static_cast<int>(std::ceil(std::min({a.y(), b.y(), c.y()}) - kEdgeSlack)), rendered_.v0);
  const int last_v =
      std::min(static_cast<int>(std::floor(std::max({a.y(), b.y(), c.y()}) + kEdgeSlack)),
               rendered_.v0 + rendered_.height - 1);
  if (first_v > last_v) return;
  const float low_u = std::min({a.x(), b.x(), c.x()}) - kEdgeSlack;
  const float high_u = std::max({a.x(), b.x(), c.x()}) + kEdgeSlack;
  if (std::ceil(low_u) > std::floor(high_u)) return;
  // 1 / z is linear in the image.
  const float inverse_area = 1.0f / doubled_area;
  const float by_u = (ab.z() * ac.y() - ac.z() * ab.y()) * inverse_area;
  const float by_v = (ac.z() * ab.x() - ab.z() * ac.x()) * inverse_area;
  const std::array<Edge, 3> edges = {Edge(a, b), Edge(b, c), Edge(c, a)};
  const int u0 = rendered_.u0;
  const float first_u = std::max(low_u, static_cast<float>(u0));
  const float last_u = std::min(high_u, static_cast<float>(u0 + rendered_.width - 1));
  for (int v = first_v; v <= last_v; v += kLanes) {
    const RowSpans spans(edges, v, first_u, last_u);
    const Floats at_rows = a.z() + by_v * (spans.rows - a.y()) - by_u * a.x();
    for (int lane = 0; lane < kLanes && v + lane <= last_v; ++lane) {
      const float at_row = at_rows[lane];
      const int end = spans.end[lane] - u0;
      const std::size_t offset = rendered_.index(0, v + lane - rendered_.v0);
      float* inverse_depths = rendered_.depth.data() + offset;
      std::int32_t* triangles = rendered_.triangle.data() + offset;
      for (int u = spans.begin[lane] - u0; u < end; u += kLanes) {
        const Ints columns = u + kLaneIndices;
        const Floats inverses = at_row + by_u * __builtin_convertvector(u0 + columns, Floats);
        const Floats farther = load<Floats>(inverse_depths + u);
        const Ints is_nearer = (inverses > farther) & (columns < end);
        store(inverse_depths + u, is_nearer ? inverses : farther);
        store(triangles + u, is_nearer ? triangle + Ints{} : load<Ints>(triangles + u));
      }
    }
  }
}

void DepthRasterizer::project(const RenderMesh& mesh, const Eigen::Isometry3f& T_camera_model,
                              const Projection& projection) {
  const Eigen::Matrix3f R = T_camera_model.linear();
  const Eigen::Vector3f t = T_camera_model.translation();
  projected_.resize(mesh.vertices.size());
  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9f);
  Eigen::Vector2f high = -low;
  float largest_inverse = 0.0f;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f p = R * mesh.vertices[i] + t;
    const float inverse = p.z() > kNearest ? 1.0f / p.z() : 0.0f;
    projected_[i] = {projection.fx * p.x() * inverse + projection.cx,
                     projection.fy * p.y() * inverse + projection.cy, inverse};
    if (!(inverse > 0.0f)) continue;
    low = low.cwiseMin(projected_[i].head<2>());
    high = high.cwiseMax(projected_[i].head<2>());
    largest_inverse = std::max(largest_inverse, inverse);
  }
  rendered_.nearest = largest_inverse > 0.0f ? 1.0f / largest_inverse : 0.0f;
  const auto bound = [](float value, int size) {
    return static_cast<int>(std::clamp(value, -1.0f, static_cast<float>(size)));
  };
  rendered_.u0 = std::max(bound(low.x(), projection.width), 0);
  rendered_.v0 = std::max(bound(low.y(), projection.height), 0);
  const int end_u = std::min(bound(high.x(), projection.width) + 1, projection.width);
  const int end_v = std::min(bound(high.y(), projection.height) + 1, projection.height);
  rendered_.width = std::max(end_u - rendered_.u0, 0);
  rendered_.height = std::max(end_v - rendered_.v0, 0);
}

const RenderedModel& DepthRasterizer::render(const RenderMesh& mesh,
                                             const Eigen::Isometry3f& T_camera_model,
                                             const Projection& projection) {
  project(mesh, T_camera_model, projection);
  const auto size =
      static_cast<std::size_t>(rendered_.width) * static_cast<std::size_t>(rendered_.height);
  // Rows are written by fours, the last one beyond its end.
  const std::size_t padded = size + kLanes;
  rendered_.depth.assign(padded, 0.0f);  // first 1 / z
  rendered_.triangle.assign(padded, -1);
  if (size == 0) return rendered_;
  // A triangle that faces away in the model's frame needs no look at its corners.
  const Eigen::Vector3f eye = -(T_camera_model.linear().transpose() * T_camera_model.translation());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3f& corner = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][0])];
    if (mesh.normals[i].dot(eye - corner) < 0.0f) continue;
    draw(mesh.triangles[i], static_cast<std::int32_t>(i));
  }
  for (std::size_t i = 0; i < size; i += kLanes) {
    const auto inverses = load<Floats>(rendered_.depth.data() + i);
    store(rendered_.depth.data() + i, inverses > 0.0f ? 1.0f / inverses : Floats{});
  }
  rendered_.depth.resize(size);
  rendered_.triangle.resize(size);
  return rendered_;
}

}  // namespace binpick
