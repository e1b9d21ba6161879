#include "recognition/pose_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "recognition/recognition_model.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

Eigen::Isometry3d pose(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& t) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  T.translation() = t;
  return T;
}

const std::vector<Eigen::Vector3f>& corners() {
  static const std::vector<Eigen::Vector3f> all = [] {
    std::vector<Eigen::Vector3f> points;
    for (const Eigen::Vector3d& p : testing::make_box({0.2, 0.1, 0.06}).vertices) {
      points.push_back(p.cast<float>());
    }
    return points;
  }();
  return all;
}

TEST(PoseMetrics, TranslationIsMeasuredExactly) {
  const Eigen::Isometry3d truth = pose(0.3, Eigen::Vector3d::UnitY(), {0.1, 0.2, 0.9});
  Eigen::Isometry3d estimate = truth;
  estimate.translation() += Eigen::Vector3d(0.003, 0.0, -0.004);
  EXPECT_NEAR(mssd(estimate, truth, corners(), {}), 0.005, 1e-12);
  EXPECT_NEAR(add(estimate, truth, corners(), {}), 0.005, 1e-12);
  EXPECT_LE(adi(estimate, truth, corners()), 0.005 + 1e-9);
  EXPECT_NEAR(pose_error(estimate, truth, {}).translation, 0.005, 1e-12);
}

TEST(PoseMetrics, EquivalentPosesHaveNoError) {
  const Eigen::Isometry3d half_turn =
      pose(std::numbers::pi, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero());
  const std::vector<Eigen::Isometry3d> symmetries = {Eigen::Isometry3d::Identity(), half_turn};
  const Eigen::Isometry3d truth = pose(0.7, Eigen::Vector3d::UnitX(), {0.0, 0.1, 1.0});
  const Eigen::Isometry3d turned = truth * half_turn;
  EXPECT_NEAR(mssd(turned, truth, corners(), symmetries), 0.0, 1e-9);
  EXPECT_NEAR(add(turned, truth, corners(), symmetries), 0.0, 1e-9);
  EXPECT_NEAR(adi(turned, truth, corners()), 0.0, 1e-6);
  EXPECT_NEAR(pose_error(turned, truth, symmetries).rotation, 0.0, 1e-7);
  // Without the symmetry the half turn moves the corners by the diagonal of the face.
  EXPECT_NEAR(mssd(turned, truth, corners(), {}), std::hypot(0.2, 0.1), 1e-6);
  EXPECT_NEAR(pose_error(turned, truth, {}).rotation, std::numbers::pi, 1e-7);
}

TEST(PoseMetrics, OrderIsAdiAddMssd) {
  const Eigen::Isometry3d truth = pose(0.2, Eigen::Vector3d::UnitX(), {0.0, 0.0, 1.0});
  const Eigen::Isometry3d estimate =
      pose(0.5, Eigen::Vector3d(1.0, 2.0, 0.5).normalized(), {0.01, 0.0, 1.01});
  EXPECT_LE(adi(estimate, truth, corners()), add(estimate, truth, corners(), {}));
  EXPECT_LE(add(estimate, truth, corners(), {}), mssd(estimate, truth, corners(), {}));
}

TEST(PoseMetrics, RmsErrorFollowsEquationSixteen) {
  const std::vector<Eigen::Vector3d> q = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  const std::vector<Eigen::Vector3d> p = {{0.0, 0.0, 3.0}, {1.0, 4.0, 0.0}};
  EXPECT_NEAR(rms_error(p, q, Eigen::Isometry3d::Identity()), std::sqrt(25.0 / 2.0), 1e-12);
}

TEST(PoseMetrics, ProjectionDistanceIsInPixels) {
  const CameraIntrinsics camera{640, 480, 500.0, 500.0, 319.5, 239.5};
  const std::vector<Eigen::Vector3f> origin = {{0.0f, 0.0f, 0.0f}};
  const Eigen::Isometry3d truth = pose(0.0, Eigen::Vector3d::UnitX(), {0.0, 0.0, 1.0});
  Eigen::Isometry3d estimate = truth;
  estimate.translation() += Eigen::Vector3d(0.006, -0.008, 0.0);
  EXPECT_NEAR(mspd(estimate, truth, origin, {}, camera), 5.0, 1e-9);  // 3 and 4 pixels
  estimate.translation().z() = -1.0;
  EXPECT_TRUE(std::isinf(mspd(estimate, truth, origin, {}, camera)));
}

TEST(PoseMetrics, OcclusionFollowsEquationFifteen) { EXPECT_EQ(occlusion(0.25, 1.0), 0.75); }

TEST(PoseMetrics, EachInstanceIsMatchedOnceBestScoreFirst) {
  // Estimates 0 and 1 are both near instance 0; 1 has the better score, 0 is left with nothing
  // below the limit; estimate 2 finds instance 1 at less than the limit, not at the limit.
  const std::vector<std::vector<double>> errors = {{0.1, 5.0}, {0.4, 0.9}, {2.0, 0.5}};
  const std::vector<double> scores = {0.3, 0.9, 0.2};
  const auto error = [&](std::size_t e, std::size_t i) { return errors[e][i]; };
  const InstanceMatching matching = match_instances(scores, 2, 0.6, error);
  EXPECT_EQ(matching.truth_of, (std::vector<std::ptrdiff_t>{-1, 0, 1}));
  EXPECT_EQ(matching.true_positives(), 2u);
  EXPECT_EQ(matching.false_positives(), 1u);
  EXPECT_EQ(matching.recall(), 1.0);
  EXPECT_EQ(match_instances(scores, 2, 0.5, error).recall(), 0.5);  // strictly below
  EXPECT_EQ(match_instances({}, 0, 0.5, error).recall(), 1.0);
}

}  // namespace
}  // namespace binpick
