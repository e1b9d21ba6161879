#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "models/geometry.h"
#include "recognition/model_library.h"

namespace binpick::testing {

/// A box about the origin, outward triangles.
TriangleMesh make_box(const Eigen::Vector3d& size);

/// A prism or, with many sides, a cylinder along z about the origin; `radius` to the corners.
TriangleMesh make_prism(int sides, double radius, double height);

TriangleMesh make_sphere(double radius);

/// A horizontal ellipse of half-axes a (x) and b (y).
struct RingProfile {
  double z = 0.0;
  double a = 0.0;
  double b = 0.0;
};
/// The body between rings of `sides` corners, closed below the first and above the last.
TriangleMesh make_loft(const std::vector<RingProfile>& profile, int sides);

/// Thin-walled, open above, its base at z = 0: a cup with many sides, an open box with four.
/// `radius` to the outer corners, `thickness` of wall and floor.
TriangleMesh make_cup(double radius, double height, double thickness, int sides);

/// The repository's three objects (models/objects) with their symmetries: bottle, amicelli, rusk.
std::vector<ModelSource> known_objects();

/// The repository's free-form toys (models/toys/*.ply), in order of their names.
/// @throws InputError when there are none.
std::vector<ModelSource> toy_objects();

/// Thin-walled ones, open above: a cup, a bowl and a square box.
std::vector<ModelSource> open_objects();

/// The models as scanning an object gives them: 0.3 mm of noise and 0.5 mm of smooth error, holes
/// of 6 to 20 mm, every second one a cloud with its points 1.5 mm apart, the others meshes.
std::vector<ModelSource> scanned(const std::vector<ModelSource>& objects);

/// Objects, exactly (meshes), and what is known of them.
struct ObjectSet {
  std::vector<ModelSource> objects;
  std::vector<ModelSource> models;
};

/// One of the sets above by its name: known, toys or open; or scans, the toys known from scans.
/// @throws InputError for another name.
ObjectSet object_set(const std::string& name);

}  // namespace binpick::testing
