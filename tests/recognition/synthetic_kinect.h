#pragma once

#include <vector>

#include "models/random.h"
#include "models/range_image.h"

namespace binpick::testing {

/// What a structured-light sensor of the Kinect's kind does to depth. Figures measured on a public
/// scan; dilation and mixed pixels are assumptions on the pessimistic side.
struct KinectNoise {
  double baseline = 0.075;        ///< m
  double disparity_step = 0.125;  ///< px
  double axial_sigma = 0.0015;    ///< times z^2, m
  double bow = 0.0025;            ///< largest slow distortion, m
  double most_dilation = 2.0;     ///< px by which silhouettes grow, at most
  double mixed_pixels = 0.15;     ///< share of edge pixels between two depths
  double grazing_cosine = 0.2;    ///< surfaces seen flatter than this drop out
};

/// A frame before the sensor: true depth and the cosine between surface normal and line of sight.
struct CleanFrame {
  RangeImage image;
  std::vector<float> cosine;
};

RangeImage add_kinect_noise(const CleanFrame& clean, const KinectNoise& noise, Seed seed);

}  // namespace binpick::testing
