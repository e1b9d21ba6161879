#include "sim/laser_scanner.h"

#include <gtest/gtest.h>

#include <cmath>

namespace binpick {
namespace {

constexpr double kWall = 1.0;
constexpr double kBlock = 0.8;

/// A wall, and before it a block over the middle third of the image, seen by a Vivid 910.
RangeImage block_before_wall() {
  RangeImage image;
  image.intrinsics = {640, 480, 1070.0, 1070.0, 319.5, 239.5};
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const bool block = u >= 213 && u < 427 && v >= 160 && v < 320;
      image.depth.push_back(static_cast<float>(block ? kBlock : kWall));
    }
  }
  return image;
}

LaserScannerOptions only_noise() {
  LaserScannerOptions options;
  options.edge_dropout = options.mixed_points = 0.0;
  options.laser_shadow = false;
  return options;
}

TEST(LaserScanner, NoiseGrowsWithTheSquareOfTheDistance) {
  RangeImage image = block_before_wall();
  apply_laser_scanner(image, only_noise(), 1);
  const auto deviation = [&](int v, double depth) {
    double squares = 0.0;
    for (int u = 220; u < 420; ++u) squares += std::pow(double{image.at(u, v)} - depth, 2);
    return std::sqrt(squares / 200.0);
  };
  double on_wall = 0.0;
  double on_block = 0.0;
  for (int k = 0; k < 50; ++k) {
    on_wall += deviation(20 + k, kWall) / 50.0;
    on_block += deviation(200 + k, kBlock) / 50.0;
  }
  EXPECT_NEAR(on_wall, 0.0003, 0.00001);
  EXPECT_NEAR(on_block, 0.0003 * kBlock * kBlock, 0.00001);
}

TEST(LaserScanner, ShadowFallsAboveTheBlockAndIsAsWideAsTheParallax) {
  RangeImage image = block_before_wall();
  LaserScannerOptions options;
  options.edge_dropout = options.mixed_points = options.axial_noise = 0.0;
  apply_laser_scanner(image, options, 1);
  // f b (1 / z_block - 1 / z_wall) = 66.9 rows of the wall are hidden from a laser below.
  int lost = 0;
  for (int v = 0; v < 160; ++v) lost += image.at(320, v) == 0.0f ? 1 : 0;
  EXPECT_NEAR(lost, 67, 1);
  for (int v = 320; v < 480; ++v) EXPECT_GT(image.at(320, v), 0.0f) << v;
  for (int v = 1; v < 479; ++v) EXPECT_GT(image.at(100, v), 0.0f) << v;
}

TEST(LaserScanner, EdgePointsAreLostOrMixedAndNoOthers) {
  RangeImage image = block_before_wall();
  LaserScannerOptions options;
  options.laser_shadow = false;
  options.axial_noise = 0.0;
  apply_laser_scanner(image, options, 3);
  int lost = 0;
  int mixed = 0;
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const float z = image.at(u, v);
      const bool near_edge = std::min(std::abs(u - 213), std::abs(u - 427)) <= 1 ||
                             std::min(std::abs(v - 160), std::abs(v - 320)) <= 1;
      const bool changed = z != static_cast<float>(kWall) && z != static_cast<float>(kBlock);
      EXPECT_TRUE(near_edge || !changed) << u << ' ' << v;
      if (changed) ++(z == 0.0f ? lost : mixed);
    }
  }
  // Two points beside every step of the outline of 214 x 160 points.
  EXPECT_NEAR(lost, 0.3 * 2 * 748, 80);
  EXPECT_NEAR(mixed, 0.1 * 2 * 748, 50);
}

TEST(LaserScanner, SameSeedSameBytes) {
  RangeImage first = block_before_wall();
  RangeImage second = first;
  RangeImage other = first;
  apply_laser_scanner(first, {}, 5);
  apply_laser_scanner(second, {}, 5);
  apply_laser_scanner(other, {}, 6);
  EXPECT_EQ(first.depth, second.depth);
  EXPECT_NE(first.depth, other.depth);
}

}  // namespace
}  // namespace binpick
