#pragma once

#include <vector>

#include "models/random.h"
#include "sim/world.h"

namespace binpick {

/// How a pile came out.
struct PileReport {
  bool settled = false;      ///< within the recipe's limit
  double settle_time = 0.0;  ///< from the last drop until rest, frame removal included, s
  std::vector<int> outside;  ///< objects whose origin ended outside the pick region
  int attempts = 0;          ///< how often the pile was built
};

/// Drops the scene's objects one after the other, in random order, place and orientation, into the
/// frame, waits for rest, takes the frame away and waits again. A pile that spills over the pick
/// region's border or never rests is built again with other draws, up to twenty times; the report
/// is the last attempt's. Same seed, same pile, bit for bit. The arm is held meanwhile. Five to ten
/// simulated seconds per attempt for seven objects.
/// @throws SimulationDiverged
PileReport drop_pile(World& world, Seed seed);

/// Steps until every object rests as the scene's recipe says. Returns whether it did in `limit` s.
bool settle(World& world, double limit);

}  // namespace binpick
