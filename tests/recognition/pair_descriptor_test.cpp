#include "recognition/pair_descriptor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "models/random.h"

namespace binpick {
namespace {

OrientedPoint random_point(Random& random) {
  OrientedPoint point;
  point.p << static_cast<float>(random.uniform(-0.1, 0.1)),
      static_cast<float>(random.uniform(-0.1, 0.1)), static_cast<float>(random.uniform(-0.1, 0.1));
  point.n = random.unit_vector().cast<float>();
  return point;
}

Eigen::Isometry3f random_pose(Random& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation().toRotationMatrix();
  T.translation() << random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 2);
  return T.cast<float>();
}

OrientedPoint moved(const Eigen::Isometry3f& T, const OrientedPoint& point) {
  return {T * point.p, T.linear() * point.n};
}

TEST(PairDescriptor, IsInvariantUnderRigidMotion) {
  Random random(11);
  for (int i = 0; i < 1000; ++i) {
    const OrientedPoint u = random_point(random);
    const OrientedPoint v = random_point(random);
    const Eigen::Isometry3f T = random_pose(random);
    const PairDescriptor before = pair_descriptor(u, v);
    const PairDescriptor after = pair_descriptor(moved(T, u), moved(T, v));
    // acos is steep at 0 and pi, where rounding of the cosine shows most.
    EXPECT_NEAR(before.normals, after.normals, 3e-3f);
    EXPECT_NEAR(before.first, after.first, 3e-3f);
    EXPECT_NEAR(before.second, after.second, 3e-3f);
  }
}

TEST(PairDescriptor, HasTheAnglesOfEquationOne) {
  const OrientedPoint u{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  const OrientedPoint v{{0.1f, 0.0f, 0.0f}, Eigen::Vector3f(1.0f, 0.0f, 1.0f).normalized()};
  const PairDescriptor f = pair_descriptor(u, v);
  constexpr float kQuarter = 0.78539816f;
  EXPECT_NEAR(f.normals, kQuarter, 1e-5f);        // angle(n_u, n_v)
  EXPECT_NEAR(f.first, 2.0f * kQuarter, 1e-5f);   // angle(n_u, p_v - p_u)
  EXPECT_NEAR(f.second, 3.0f * kQuarter, 1e-5f);  // angle(n_v, p_u - p_v)
}

TEST(PairFrame, AlignmentRecoversTheTransform) {
  // Eq. (2): T = F_wx F_uv^-1 maps (u, v) to its moved copy.
  Random random(12);
  int frames = 0;
  for (int i = 0; i < 1000; ++i) {
    const OrientedPoint u = random_point(random);
    const OrientedPoint v = random_point(random);
    const Eigen::Isometry3f T = random_pose(random);
    const auto F_uv = pair_frame(u, v);
    const auto F_wx = pair_frame(moved(T, u), moved(T, v));
    if (!F_uv || !F_wx) continue;
    ++frames;
    EXPECT_TRUE((*F_wx * F_uv->inverse()).isApprox(T, 1e-3f));
  }
  EXPECT_GT(frames, 900);
}

TEST(PairFrame, IsARotationWithTheAxesOfEquationThree) {
  const OrientedPoint u{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  const OrientedPoint v{{0.2f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  const auto F = pair_frame(u, v);
  ASSERT_TRUE(F);
  EXPECT_TRUE(F->linear().col(0).isApprox(Eigen::Vector3f(0.0f, -1.0f, 0.0f)));  // p_uv x n_uv
  EXPECT_TRUE(F->linear().col(1).isApprox(Eigen::Vector3f(1.0f, 0.0f, 0.0f)));   // p_uv
  EXPECT_TRUE(F->linear().col(2).isApprox(Eigen::Vector3f(0.0f, 0.0f, 1.0f)));
  EXPECT_TRUE(F->translation().isApprox(Eigen::Vector3f(0.1f, 0.0f, 0.0f)));
  EXPECT_NEAR(F->linear().determinant(), 1.0f, 1e-5f);
}

TEST(PairFrame, IsRefusedWhereItIsUndefined) {
  const OrientedPoint u{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  EXPECT_FALSE(pair_frame(u, u));                                          // no distance
  EXPECT_FALSE(pair_frame(u, {{0.1f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}}));  // opposite normals
  EXPECT_FALSE(pair_frame({{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}},
                          {{0.1f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}}));  // normals along the line
}

TEST(PairDescriptor, CoplanarPairsAreTold) {
  const OrientedPoint u{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  EXPECT_TRUE(is_coplanar(pair_descriptor(u, {{0.1f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}})));
  // Parallel faces at different heights are not one plane.
  EXPECT_FALSE(is_coplanar(pair_descriptor(u, {{0.05f, 0.0f, 0.05f}, {0.0f, 0.0f, 1.0f}})));
  EXPECT_FALSE(is_coplanar(pair_descriptor(u, {{0.1f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}})));
}

}  // namespace
}  // namespace binpick
