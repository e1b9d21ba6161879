#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "recognition/recognition_score.h"
#include "recognition/recognizer.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Rotation vector and translation that take the truth to the estimate, in the scene's axes.
Vector6d error_of(const Eigen::Isometry3d& T_estimated, const Eigen::Isometry3d& T_true) {
  const Eigen::AngleAxisd turn(T_estimated.linear() * T_true.linear().transpose());
  Vector6d error;
  error << turn.angle() * turn.axis(), T_estimated.translation() - T_true.translation();
  return error;
}

/// The least normalised error squared over the poses that cannot be told apart.
double normalised_square(const Detection& detection, const Eigen::Isometry3d& T_true,
                         const std::vector<Eigen::Isometry3d>& symmetries) {
  double least = 1e300;
  for (const Eigen::Isometry3d& symmetry : symmetries) {
    const Vector6d error = error_of(detection.T_scene_model, T_true * symmetry);
    least = std::min(least, error.dot(detection.covariance.ldlt().solve(error)));
  }
  return least;
}

TEST(Covariance, NormalisedErrorsAreNearTheirNumberOfFreedoms) {
  const testing::SceneGenerator generator(testing::known_objects());
  const auto library = std::make_shared<const ModelLibrary>(testing::known_objects());
  RecognizerOptions options;
  options.jobs = 2;
  const Recognizer recognizer(library, options);
  std::vector<double> squares;
  for (std::uint64_t i = 0; i < 24; ++i) {
    const Seed seed = testing::frame_seed(1900, "kinect", i);
    const testing::SyntheticFrame frame =
        generator.frame(testing::draw_parameters("kinect", seed), seed);
    const RecognitionResult result = testing::recognize(recognizer, frame, seed);
    const testing::FrameScore score =
        testing::score_frame(result.detections, frame, library->models());
    for (const testing::FrameScore::Match& match : score.matches) {
      const testing::TrueInstance& truth = frame.scene.instances[match.instance];
      squares.push_back(normalised_square(result.detections[match.detection],
                                          frame.T_scene_camera * truth.T_camera_model,
                                          library->models()[truth.model].symmetries));
    }
  }
  ASSERT_GT(squares.size(), 60u);
  const double median = testing::quantile(squares, 0.5);
  const double p95 = testing::quantile(squares, 0.95);
  std::printf(
      "normalised error squared of %zu poses: median %.1f (chi-square of six: 5.3), "
      "95th percentile %.1f (12.6)\n",
      squares.size(), median, p95);
  // Within a factor of 1.6 in the error's size: shape error and the sensor's slow distortion are
  // known by their order of magnitude only.
  EXPECT_GT(median, 5.35 / 2.5);
  EXPECT_LT(median, 5.35 * 2.5);
  EXPECT_LT(p95, 12.6 * 2.5);
}

}  // namespace
}  // namespace binpick
