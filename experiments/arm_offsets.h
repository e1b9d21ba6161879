#pragma once

#include "experiments/trial_kind.h"
#include "models/config_visitor.h"
#include "sim/simulated_robot.h"

namespace binpick {

/// How far an arm and its jaws may be off: each trial draws its offsets uniformly in plus and minus
/// these. Ranges and sources: docs/table1.md.
struct ArmOffsets {
  double torque = 0.0;   ///< of each joint torque sensor, Nm
  double joint = 0.0;    ///< of each joint's zero, rad
  double opening = 0.0;  ///< of the distance of the jaws, m

  void visit(ConfigVisitor& visitor);
  /// Enters the trial's offsets, on top of the torque sensors' own.
  void configure(SimulatedRobotOptions& options, const TrialContext& context) const;
};

}  // namespace binpick
