#include "recognition/point_kernels.h"

#include <gtest/gtest.h>

#include "models/random.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

/// Poses near true ones and far from any, partly outside the image and behind the sensor.
std::vector<Eigen::Isometry3f> poses_about(const Eigen::Isometry3d& T_camera_model) {
  Random random(8);
  std::vector<Eigen::Isometry3f> poses = {T_camera_model.cast<float>()};
  for (int i = 0; i < 60; ++i) {
    Eigen::Isometry3d T = T_camera_model;
    if (i % 2 == 0) T.linear() = random.rotation().toRotationMatrix();
    T.translation() += random.uniform(0.0, i % 4 == 0 ? 1.5 : 0.02) * random.unit_vector();
    poses.push_back(T.cast<float>());
  }
  return poses;
}

TEST(PointKernels, FastestAndPortableOnesGiveTheSameBits) {
  const std::vector<ModelSource> sources = testing::known_objects();
  const auto scene = testing::SceneGenerator(sources).make(testing::SceneKind::kPile, 3);
  const ObservedScene observed(scene.clean.image, {0.005, 0.054}, 1, 1);
  const PointKernels portable = portable_kernels();
  const PointKernels best = best_kernels();
  int matched = 0;
  int pairs = 0;
  for (const testing::TrueInstance& instance : scene.instances) {
    const ModelSource& source = sources[instance.model];
    const RecognitionModel model = make_recognition_model(
        source.name, std::get<TriangleMesh>(source.shape), source.symmetries);
    for (const Eigen::Isometry3f& T : poses_about(instance.T_camera_model)) {
      // Ranges that are no multiples of the vector length, too.
      for (const auto& [begin, end] : {std::pair{0, 512}, {3, 39}, {128, 131}, {0, 2000}}) {
        const auto first = static_cast<std::size_t>(begin);
        const auto last = static_cast<std::size_t>(end);
        const FacingCounts a = portable.count_facing(observed, model, T, 0.004f, first, last);
        const FacingCounts b = best.count_facing(observed, model, T, 0.004f, first, last);
        EXPECT_EQ(a.facing, b.facing);
        EXPECT_EQ(a.matched, b.matched);
        EXPECT_EQ(a.occluding, b.occluding);
        matched += a.matched;
        const NormalEquations c = portable.normal_equations(observed, model, T, 0.01f, last);
        const NormalEquations d = best.normal_equations(observed, model, T, 0.01f, last);
        EXPECT_EQ(c.pairs, d.pairs);
        EXPECT_EQ(c.information, d.information);
        EXPECT_EQ(c.right, d.right);
        pairs += c.pairs;
      }
    }
  }
  EXPECT_GT(matched, 1000);
  EXPECT_GT(pairs, 1000);
}

}  // namespace
}  // namespace binpick
