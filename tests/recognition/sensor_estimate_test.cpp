#include <gtest/gtest.h>

#include <cmath>

#include "models/random.h"
#include "recognition/observed_scene.h"

namespace binpick {
namespace {

/// A slanted wall from 0.6 m to 1.4 m with independent noise of sigma(z).
template <class Sigma>
SensorEstimate estimate(const Sigma& sigma) {
  RangeImage image;
  image.intrinsics = {320, 240, 290.0, 290.0, 159.5, 119.5};
  Random random(11);
  for (int v = 0; v < 240; ++v) {
    // A plane: 1 / z is linear in v.
    const double z = 1.0 / (1.0 / 0.6 + (1.0 / 1.4 - 1.0 / 0.6) * v / 239.0);
    for (int u = 0; u < 320; ++u) {
      image.depth.push_back(static_cast<float>(z + sigma(z) * random.normal()));
    }
  }
  return ObservedScene(image, {1e-6, 1e9}, 1, 1).sensor();
}

TEST(SensorEstimate, RecoversATriangulatingSensor) {
  const SensorEstimate sensor = estimate([](double z) { return 0.0015 * z * z; });
  for (const float z : {0.7f, 1.0f, 1.3f}) {
    EXPECT_NEAR(std::sqrt(sensor.axial_variance(z)), 0.0015f * z * z, 0.0003f * z * z);
  }
  EXPECT_LT(sensor.correlated_pixels, 2.0f);
}

TEST(SensorEstimate, RecoversALaserScanner) {
  const SensorEstimate sensor = estimate([](double) { return 0.0004; });
  for (const float z : {0.7f, 1.0f, 1.3f}) {
    EXPECT_NEAR(std::sqrt(sensor.axial_variance(z)), 0.0004f, 0.0001f);
  }
}

TEST(SensorEstimate, SlantTurnsLateralIntoNormalNoise) {
  SensorEstimate sensor;
  sensor.constant = 0.001f;
  sensor.lateral = 0.5f;
  EXPECT_FLOAT_EQ(sensor.normal_variance(1.0f, -1.0f, 0.003f), 1e-6f);
  EXPECT_FLOAT_EQ(sensor.normal_variance(1.0f, 0.0f, 0.003f), 0.0015f * 0.0015f);
}

}  // namespace
}  // namespace binpick
