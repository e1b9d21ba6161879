#include "recognition/depth_rasterizer.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "models/random.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

Projection camera() { return {160, 120, 140.0f, 150.0f, 79.5f, 59.5f}; }

/// Distance along the ray to a triangle (Moeller and Trumbore, 1997).
std::optional<double> hit(const Eigen::Vector3d& direction, const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const Eigen::Vector3d p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (std::abs(determinant) < 1e-15) return std::nullopt;
  const double u = -a.dot(p) / determinant;
  const Eigen::Vector3d q = (-a).cross(ab);
  const double v = direction.dot(q) / determinant;
  if (u < 0.0 || v < 0.0 || u + v > 1.0) return std::nullopt;
  return ac.dot(q) / determinant;
}

TEST(DepthRasterizer, MatchesRayCasting) {
  Random random(5);
  DepthRasterizer rasterizer;
  for (int trial = 0; trial < 20; ++trial) {
    const TriangleMesh mesh =
        trial % 2 == 0 ? testing::make_box({0.15, 0.1, 0.06}) : testing::make_prism(6, 0.05, 0.14);
    const RecognitionModel model = make_recognition_model("model", mesh, {});
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = random.rotation().toRotationMatrix();
    T.translation() << random.uniform(-0.3, 0.3), random.uniform(-0.2, 0.2),
        random.uniform(0.5, 1.0);
    const Projection projection = camera();
    const RenderedModel& rendered =
        rasterizer.render(model.render_mesh, T.cast<float>(), projection);
    int wrong = 0;
    int covered = 0;
    for (int v = 0; v < projection.height; ++v) {
      for (int u = 0; u < projection.width; ++u) {
        const Eigen::Vector3d ray = projection.point(u, v, 1.0f).cast<double>();
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& t : mesh.triangles) {
          const auto corner = [&](std::size_t i) {
            return Eigen::Vector3d(T * mesh.vertices[static_cast<std::size_t>(t[i])]);
          };
          if (const auto z = hit(ray, corner(0), corner(1), corner(2))) {
            nearest = std::min(nearest, *z);
          }
        }
        const bool covers = rendered.covers(u - rendered.u0, v - rendered.v0);
        if (covers) ++covered;
        if (covers != (nearest < 10.0)) {
          ++wrong;  // a pixel centre within rounding of an edge
        } else if (covers) {
          const float z = rendered.depth[rendered.index(u - rendered.u0, v - rendered.v0)];
          EXPECT_NEAR(z, nearest, 2e-4);
        }
      }
    }
    EXPECT_GT(covered, 50);
    EXPECT_LE(wrong, 3);
  }
}

TEST(DepthRasterizer, DrawsNothingBehindTheCamera) {
  const RecognitionModel model =
      make_recognition_model("box", testing::make_box({0.1, 0.1, 0.1}), {});
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translation().z() = -1.0f;
  DepthRasterizer rasterizer;
  const RenderedModel& rendered = rasterizer.render(model.render_mesh, T, camera());
  for (const float z : rendered.depth) EXPECT_EQ(z, 0.0f);
}

}  // namespace
}  // namespace binpick
