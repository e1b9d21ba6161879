#pragma once

#include "models/random.h"
#include "models/range_image.h"

namespace binpick {

/// A first model of a Kinect v1: what triangulation with a projected pattern does to depth. Every
/// part can be switched off by its zero.
struct StructuredLightOptions {
  bool enabled = true;
  double baseline = 0.075;          ///< between projector and camera, m
  double disparity_step = 0.125;    ///< px; 0: not quantised
  double axial_noise = 0.0015;      ///< sigma / z^2, quantisation included, 1/m
  double noise_grain = 4.0;         ///< correlation length of the noise, px
  double edge_threshold = 0.02;     ///< relative depth step that makes an edge
  double edge_raggedness = 1.5;     ///< silhouettes move by up to this, px
  double edge_dropout = 0.25;       ///< share of edge pixels without a value
  double grazing_limit_deg = 78.0;  ///< steeper surfaces return nothing; 90: off
  bool projector_shadow = true;
  double bow = 0.0;         ///< smooth depth error at the corners at 1 m, m
  double min_range = 0.45;  ///< m
  double max_range = 3.5;   ///< m
};

/// Spoils the ideal range image in place. Same seed, same bytes. About 2 ms for 640 x 480.
void apply_structured_light(RangeImage& image, const StructuredLightOptions& options, Seed seed);

}  // namespace binpick
