#pragma once

#include <cmath>

namespace binpick {

/// What eq. (11) needs.
struct SamplingOdds {
  double scene_points = 0.0;          ///< n, points of S*
  double instance_points = 0.0;       ///< m, points of S* on the least instance to be found
  double kept_fraction = 1.0;         ///< K, share of pairs in the hash table
  double same_object_share = 0.25;    ///< C
  double success_probability = 0.99;  ///< P_S
};

/// N, the number of pairs to draw so that an instance is hit with the wanted probability.
/// IJRR 2012, eq. (11): N = -n ln(1 - P_S) / (m K C), rounded up.
[[nodiscard]] inline double iteration_count(const SamplingOdds& odds) {
  return std::ceil(-odds.scene_points * std::log1p(-odds.success_probability) /
                   (odds.instance_points * odds.kept_fraction * odds.same_object_share));
}

}  // namespace binpick
