#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "models/geometry.h"
#include "models/random.h"

namespace binpick::testing {

/// A surface to be drawn and piled up: finely divided triangles and points a few millimetres apart.
struct Shape {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<Eigen::Vector3f> cover;
  Eigen::Vector3f sides = Eigen::Vector3f::Zero();  ///< of the bounding box, longest first
};

/// Divides the mesh until no edge is longer than `longest_edge`, and covers it with points.
[[nodiscard]] Shape make_shape(const TriangleMesh& mesh, double longest_edge = 0.012);

/// How a real object differs from its model.
struct ShapeError {
  double scale = 1.0;  ///< true size over the model's
  double displacement =
      0.0;  ///< largest displacement of the surface, smooth over half the object, m
};

/// The object itself: scaled about the model's origin and bent smoothly. What a rigid motion could
/// undo is taken out, so that the model's pose stays the best one.
[[nodiscard]] Shape distorted(const Shape& model, const ShapeError& error, Seed seed);

/// An object that is no model: a box, prism, cylinder, ellipsoid, blob, vase, cup or open box of
/// random size. No two of its sides are like two sides of one of `models` (such a one could not be
/// told from the model when it shows one face only).
[[nodiscard]] Shape make_unknown(std::span<const Shape> models, Random& random);

/// A level rectangle about the origin, divided so finely that the camera can stand above it.
[[nodiscard]] Shape make_board(double width, double depth);

/// Four upright walls of a box without a floor, standing on z = 0.
[[nodiscard]] Shape make_walls(const Eigen::Vector2d& inside, double height, double thickness);

}  // namespace binpick::testing
