#pragma once

#include "models/random.h"
#include "models/range_image.h"

namespace binpick {

/// A light-section laser scanner of the class of the Konica Minolta Vivid 910, with which the
/// scenes of IJRR 2012, section 6.1, were taken: a camera of 640 x 480 points watches a laser
/// stripe that sweeps the scene. Depth comes from triangulation over a vertical baseline. Every
/// part can be switched off by its zero.
struct LaserScannerOptions {
  /// Between camera and laser, which stands below it, m. Not published; the housing of the
  /// Vivid 910 is 0.41 m high.
  double baseline = 0.25;
  /// sigma / z^2, 1/m: 0.1 mm at 0.6 m, 0.5 mm at 1.3 m. Independent from point to point.
  double axial_noise = 0.0003;
  double edge_threshold = 0.01;     ///< relative depth step that makes an edge
  double edge_dropout = 0.3;        ///< share of edge points without a value
  double mixed_points = 0.1;        ///< share of edge points between the two depths
  double grazing_limit_deg = 80.0;  ///< steeper surfaces return nothing; 90: off
  bool laser_shadow = true;
};

/// Spoils the ideal range image in place. Same seed, same bytes. O(pixels).
void apply_laser_scanner(RangeImage& image, const LaserScannerOptions& options, Seed seed);

}  // namespace binpick
