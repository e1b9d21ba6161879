#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "models/geometry.h"
#include "recognition/pair_descriptor.h"

namespace binpick {

/// Triangles for the rasteriser, single precision, with outward unit normals.
struct RenderMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<Eigen::Vector3f> normals;  ///< one per triangle
  /// One per triangle, 1/m^2: within a small distance r of it the mean normal is as short as 1 -
  /// roughness r^2. Normals that a scene shows of rough parts (horns, fingers, creases) mean
  /// little.
  std::vector<float> roughness;
};

/// Oriented points as structure of arrays, in an order whose every prefix covers the surface
/// uniformly.
struct TestPoints {
  std::vector<float> x, y, z;
  std::vector<float> nx, ny, nz;

  [[nodiscard]] std::size_t size() const noexcept { return x.size(); }
  [[nodiscard]] Eigen::Vector3f p(std::size_t i) const { return {x[i], y[i], z[i]}; }
  [[nodiscard]] Eigen::Vector3f n(std::size_t i) const { return {nx[i], ny[i], nz[i]}; }
};

/// M, one object as the recognizer needs it, in the model's own frame, metres.
struct RecognitionModel {
  std::string name;
  std::vector<Eigen::Isometry3d> symmetries;   ///< identity first
  std::vector<OrientedPoint> surface;          ///< nearly uniform: what pairs are made of
  std::vector<Eigen::Vector3f> cover;          ///< denser, at the spacing of the leaves of S*
  std::vector<Eigen::Vector3f> cover_normals;  ///< of the cover's points
  TestPoints test_points;                      ///< what mu compares with the scene
  RenderMesh render_mesh;
  std::vector<Eigen::Vector3f> hull;  ///< extreme points, for distances and half-spaces
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  float diameter = 0.0f;       ///< largest distance between two points, m
  float middle_extent = 0.0f;  ///< second of the three sides of the fitted box, m
  float largest_face = 0.0f;   ///< product of its two longest sides, m^2
  float area = 0.0f;           ///< of the whole surface, m^2
};

/// Replaces `model.surface` by an even subset of its cover, `points_per_diameter` of them along a
/// line as long as the model's diameter.
void set_pair_points(RecognitionModel& model, float points_per_diameter);

/// Prepares a closed or open triangle mesh. Without `symmetries` they are found by registering the
/// surface with itself. @throws InputError when it has no area.
[[nodiscard]] RecognitionModel make_recognition_model(
    const std::string& name, const TriangleMesh& mesh,
    const std::vector<Eigen::Isometry3d>& symmetries);

/// Prepares a scanned cloud, in the same way; see ModelSource on normals. @throws InputError when
/// it has fewer than ten finite points or no extent.
[[nodiscard]] RecognitionModel make_recognition_model(
    const std::string& name, const PointCloud& cloud,
    const std::vector<Eigen::Isometry3d>& symmetries);

}  // namespace binpick
