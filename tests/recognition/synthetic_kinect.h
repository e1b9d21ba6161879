#pragma once

#include "recognition/synthetic_sensor.h"

namespace binpick::testing {

/// The frame as a Kinect v1 measures it.
inline RangeImage add_kinect_noise(const CleanFrame& clean, const SensorNoise& noise, Seed seed) {
  return add_sensor_noise(clean, noise, seed);
}

}  // namespace binpick::testing
