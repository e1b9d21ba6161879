#include "sim/structured_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace binpick {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kFocal = 575.0;

RangeImage image_of(const std::function<double(double, double)>& depth) {
  RangeImage image;
  image.intrinsics = {kWidth, kHeight, kFocal, kFocal, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      image.depth.push_back(static_cast<float>(
          depth((u - image.intrinsics.cx) / kFocal, (v - image.intrinsics.cy) / kFocal)));
    }
  }
  return image;
}

RangeImage wall_at(double z) {
  return image_of([z](double, double) { return z; });
}

// Seen over a wall at 1 m: a plate of 160 pixels width at 0.7 m in the image's middle.
bool on_plate(double x) { return std::abs(x) < 80.0 / kFocal; }
RangeImage plate() {
  return image_of([](double x, double) { return on_plate(x) ? 0.7 : 1.0; });
}

double local_rms(const RangeImage& noisy, const RangeImage& clean) {
  // Deviations from the mean of each patch of about 3 cm, as in the measurement on the scan.
  double squares = 0.0;
  double count = 0.0;
  const int patch = static_cast<int>(0.03 * kFocal / double{clean.depth[0]});
  for (int v = 20; v + patch < kHeight - 20; v += patch) {
    for (int u = 100; u + patch < kWidth - 20; u += patch) {
      double sum = 0.0;
      double sum_squares = 0.0;
      for (int dv = 0; dv < patch; ++dv) {
        for (int du = 0; du < patch; ++du) {
          const double error = double{noisy.at(u + du, v + dv)} - double{clean.at(u + du, v + dv)};
          sum += error;
          sum_squares += error * error;
        }
      }
      squares += sum_squares - sum * sum / (patch * patch);
      count += patch * patch;
    }
  }
  return std::sqrt(squares / count);
}

class AxialNoise : public ::testing::TestWithParam<double> {};

TEST_P(AxialNoise, GrowsWithTheSquareOfTheDistance) {
  const double z = GetParam();
  // Slightly tilted, so that rounding errors average out over the patch as on a real table.
  const RangeImage clean =
      image_of([z](double x, double y) { return z * (1.0 + 0.2 * x + 0.3 * y); });
  RangeImage noisy = clean;
  apply_structured_light(noisy, {}, 4);
  const double expected = 0.0015 * z * z;
  EXPECT_GT(local_rms(noisy, clean), 0.8 * expected);
  EXPECT_LT(local_rms(noisy, clean), 1.2 * expected);
}

INSTANTIATE_TEST_SUITE_P(StructuredLight, AxialNoise, ::testing::Values(0.8, 1.0, 1.2));

TEST(StructuredLight, DepthIsQuantisedInDisparity) {
  RangeImage noisy = wall_at(1.0);
  apply_structured_light(noisy, {}, 1);
  std::set<float> values(noisy.depth.begin(), noisy.depth.end());
  values.erase(0.0f);
  ASSERT_GT(values.size(), 2u);
  const double focal_baseline = kFocal * 0.075;
  for (const float z : values) {
    const double steps = focal_baseline / double{z} / 0.125;
    EXPECT_NEAR(steps, std::round(steps), 1e-3);
  }
  // One step at 1 m.
  EXPECT_NEAR(double{*std::next(values.begin())} - double{*values.begin()}, 0.0029, 3e-4);
}

TEST(StructuredLight, ProjectorCastsAShadowToTheLeft) {
  StructuredLightOptions options;
  options.edge_dropout = 0.0;
  options.edge_raggedness = 0.0;
  RangeImage noisy = plate();
  apply_structured_light(noisy, options, 1);
  const double shift = kFocal * options.baseline * (1.0 / 0.7 - 1.0);
  int left = 0;
  int right = 0;
  for (int u = 0; u < kWidth; ++u) {
    const double x = (u - noisy.intrinsics.cx) / kFocal;
    if (noisy.at(u, 240) > 0.0f || on_plate(x)) continue;
    (x < 0.0 ? left : right) += 1;
  }
  EXPECT_NEAR(left, shift, 1.5);
  EXPECT_EQ(right, 0);
}

TEST(StructuredLight, SilhouettesAreRaggedWithinTwoPixels) {
  StructuredLightOptions options;
  options.projector_shadow = false;
  RangeImage noisy = plate();
  const RangeImage clean = plate();
  apply_structured_light(noisy, options, 1);
  int moved = 0;
  int lost = 0;
  for (int v = 10; v < kHeight - 10; ++v) {
    for (int u = 10; u < kWidth - 10; ++u) {
      const double from_edge = std::abs(std::abs(u - noisy.intrinsics.cx) - 80.0);
      const bool missing = noisy.at(u, v) == 0.0f;
      const bool other_side = !missing && std::abs(noisy.at(u, v) - clean.at(u, v)) > 0.1f;
      moved += other_side ? 1 : 0;
      lost += missing ? 1 : 0;
      if (missing || other_side) {
        EXPECT_LT(from_edge, 3.0);
      }
    }
  }
  EXPECT_GT(moved, 100);
  EXPECT_GT(lost, 100);
}

TEST(StructuredLight, GrazedSurfacesReturnNothingAndStepsStay) {
  StructuredLightOptions options;
  options.projector_shadow = false;
  options.edge_dropout = 0.0;
  options.edge_raggedness = 0.0;
  // A plane through (0, 0, 1 m) whose normal is `angle` off the line of sight there.
  const auto centre_seen_at = [&](double angle_deg) {
    const double slope = std::tan(angle_deg * M_PI / 180.0);
    RangeImage image = image_of([slope](double, double y) { return 1.0 / (1.0 - slope * y); });
    apply_structured_light(image, options, 1);
    return image.at(kWidth / 2, kHeight / 2);
  };
  EXPECT_GT(centre_seen_at(options.grazing_limit_deg - 3.0), 0.0f);
  EXPECT_EQ(centre_seen_at(options.grazing_limit_deg + 3.0), 0.0f);
  RangeImage stepped = plate();
  apply_structured_light(stepped, options, 1);
  EXPECT_EQ(std::count(stepped.depth.begin(), stepped.depth.end(), 0.0f), 0);
}

TEST(StructuredLight, OffLeavesTheImageAlone) {
  StructuredLightOptions options;
  options.enabled = false;
  RangeImage image = plate();
  apply_structured_light(image, options, 1);
  EXPECT_EQ(image.depth, plate().depth);
}

TEST(StructuredLight, SameSeedGivesSameBytes) {
  RangeImage first = plate();
  RangeImage second = plate();
  RangeImage other = plate();
  apply_structured_light(first, {}, 9);
  apply_structured_light(second, {}, 9);
  apply_structured_light(other, {}, 10);
  EXPECT_EQ(first.depth, second.depth);
  EXPECT_NE(first.depth, other.depth);
}

TEST(StructuredLight, BowBendsTheCorners) {
  StructuredLightOptions options;
  options.bow = 0.004;
  options.disparity_step = 0.0;
  options.axial_noise = 0.0;
  RangeImage image = wall_at(1.0);
  apply_structured_light(image, options, 1);
  EXPECT_NEAR(image.at(0, 0), 1.004, 1e-5);
  EXPECT_NEAR(image.at(320, 240), 1.0, 1e-5);
}

}  // namespace
}  // namespace binpick
