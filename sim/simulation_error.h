#pragma once

#include <stdexcept>

namespace binpick {

/// The physics left the rails: a MuJoCo warning (NaN, huge velocity, full buffer), time that did
/// not advance or a state that is not finite. The world's state is of no further use.
class SimulationDiverged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The robot's own safety closed the brakes: a limit was exceeded or a sensor failed. The message
/// says when, which joint, and what.
class RobotStopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A simulated robot used up the simulated time it was given.
class TimeBudgetSpent : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace binpick
