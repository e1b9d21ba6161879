#include "recognition/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace binpick {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rod from the origin to x = 0.2 m, of revolution about it if it is `round`.
RecognitionModel rod(bool round) {
  RecognitionModel model;
  model.diameter = 0.2f;
  model.hull = {{0.0f, 0.0f, 0.0f}, {0.2f, 0.0f, 0.0f}, {0.1f, 0.02f, 0.0f}, {0.1f, 0.0f, -0.02f}};
  const int order = round ? 36 : 2;
  for (int i = 0; i < order; ++i) {
    model.symmetries.emplace_back(
        Eigen::AngleAxisd(2.0 * std::numbers::pi * i / order, Eigen::Vector3d::UnitX()));
  }
  return model;
}

Eigen::Isometry3d somewhere() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.1, -0.2, 0.9);
  return T;
}

/// Independent turns about the model's own axes and shifts, variances.
Matrix6d covariance_of(const Eigen::Isometry3d& T, const Eigen::Vector3d& turns, double shift) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = T.linear() * turns.asDiagonal() * T.linear().transpose();
  covariance.bottomRightCorner<3, 3>() = shift * Eigen::Matrix3d::Identity();
  return covariance;
}

TEST(PoseUncertainty, GrowsWithTheLeverOfTheFarthestPoint) {
  const Eigen::Isometry3d T = somewhere();
  EXPECT_NEAR(
      most_uncertain_motion(rod(false), T, covariance_of(T, {0.0, 0.0, 0.0}, 4e-6)).displacement,
      0.002, 1e-9);
  // 0.05 rad about z at 0.2 m.
  EXPECT_NEAR(
      most_uncertain_motion(rod(false), T, covariance_of(T, {0.0, 0.0, 0.0025}, 0.0)).displacement,
      0.01, 1e-9);
  EXPECT_NEAR(
      most_uncertain_motion(rod(false), T, covariance_of(T, {0.0, 0.0, 0.0025}, 4e-6)).displacement,
      std::hypot(0.01, 0.002), 1e-9);
}

TEST(PoseUncertainty, TurnsOfABodyOfRevolutionDoNotCount) {
  const Eigen::Isometry3d T = somewhere();
  const Matrix6d turned = covariance_of(T, {0.04, 0.0, 0.0}, 1e-6);
  EXPECT_NEAR(most_uncertain_motion(rod(false), T, turned).displacement,
              std::hypot(0.2 * 0.02, 0.001), 1e-9);
  EXPECT_NEAR(most_uncertain_motion(rod(true), T, turned).displacement, 0.001, 1e-9);
}

TEST(PoseUncertainty, ATurnThatComesWithAShiftTakesItAlong) {
  // A rod that may roll: what its turn explains of the shift is known once the turn is.
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, 1> roll;
  roll << 0.1, 0.0, 0.0, 0.0, 0.002, 0.0;
  EXPECT_NEAR(most_uncertain_motion(rod(true), T, roll * roll.transpose()).displacement, 0.0, 1e-9);
}

TEST(PoseUncertainty, MovesThePointThatIsLeastCertainAsFarAsAsked) {
  const Eigen::Isometry3d T = somewhere();
  const UncertainMotion motion =
      most_uncertain_motion(rod(false), T, covariance_of(T, {0.0, 0.0, 0.0025}, 0.0));
  const Eigen::Vector3d end(0.2, 0.0, 0.0);
  for (const double distance : {0.002, -0.004}) {
    const Eigen::Isometry3d moved = motion.move(T, distance);
    EXPECT_NEAR((moved * end - T * end).norm(), std::abs(distance), 1e-6);
    EXPECT_TRUE((moved * Eigen::Vector3d::Zero()).isApprox(T * Eigen::Vector3d::Zero()));
  }
  // There and back again.
  const Eigen::Isometry3d there = motion.move(T, 0.01);
  EXPECT_TRUE(motion.move(there, -0.01).isApprox(T, 1e-12));
}

}  // namespace
}  // namespace binpick
