#pragma once

#include <cstdint>
#include <vector>

#include "models/random.h"
#include "models/range_image.h"

namespace binpick::testing {

/// What a depth sensor does to true depth. The defaults are a Kinect v1: noise, bow and ragged
/// silhouettes as measured on a public scan; 1/8 px and 75 mm as in Khoshelham & Elberink,
/// "Accuracy and resolution of Kinect depth data", Sensors 2012. Lengths in px belong to the image
/// at hand.
struct SensorNoise {
  // Error of a measured depth: standard deviation sigma_0 + sigma_1 z + sigma_2 z^2, m.
  double sigma_0 = 0.0;      ///< m
  double sigma_1 = 0.0;      ///< m per m
  double sigma_2 = 0.0015;   ///< m per m^2; Khoshelham & Elberink: 1.4 mm, measured: 1.5 mm
  double correlated = 0.64;  ///< share of the variance that is alike over about six pixels
  /// Growth with incidence theta: sigma += this theta^2 / (pi/2 - theta)^2 / sqrt(z). Nguyen, Izadi
  /// and Lovell, "Modeling Kinect sensor noise", 3DIMPVT 2012: 0.1 mm.
  double grazing_sigma = 0.0001;
  double bow = 0.0025;  ///< largest slow distortion, m
  /// Disparities are multiples of this, px; 0 for a sensor that does not measure disparity.
  double disparity_step = 0.125;
  /// Between camera and projector (to its right), m: quantisation and shadows follow from it.
  double baseline = 0.075;

  // Silhouettes.
  double most_dilation = 1.0;   ///< px by which nearer surfaces grow, at most; 0 to this, varying
  double least_dilation = 0.0;  ///< px by which they grow everywhere
  double raggedness = 0.7;      ///< px, standard deviation of the silhouettes' displacement
  double mixed_pixels = 0.15;   ///< share of edge pixels that lie between two depths
  /// px: depth is the mean over a window of this radius, as far as it holds the same surface. A
  /// Kinect v1 correlates windows of 9 x 9 px of 1280 (Konolige & Mihelich 2010).
  int window = 2;

  // Where nothing is measured.
  double shadow_margin = 1.0;   ///< px beside a projector shadow that are lost too, at most
  double grazing_cosine = 0.2;  ///< surfaces seen flatter than this mostly drop out
  double shiny_share = 0.0;     ///< of the image, lost in patches of about a dozen pixels
};

/// A frame before the sensor: true depth, cosine between surface normal and line of sight, and what
/// is seen.
struct CleanFrame {
  RangeImage image;
  std::vector<float> cosine;
  std::vector<std::int16_t> owner;  ///< index of the known instance, kForeign or kGround

  static constexpr std::int16_t kForeign = -1;
  static constexpr std::int16_t kGround = -2;  ///< table, floor, walls
};

/// What the sensor delivers of the frame.
[[nodiscard]] RangeImage add_sensor_noise(const CleanFrame& clean, const SensorNoise& noise,
                                          Seed seed);

/// 1 for every pixel that the projector does not light.
[[nodiscard]] std::vector<std::uint8_t> projector_shadow(const RangeImage& clean, double baseline);

}  // namespace binpick::testing
