#include "experiments/arm_offsets.h"

#include "models/random.h"

namespace binpick {

void ArmOffsets::visit(ConfigVisitor& visitor) {
  visitor.number("torque_offset", torque, {.min = 0.0, .max = 10.0});
  visitor.number("joint_offset_deg", joint, {.min = 0.0, .max = 5.0, .unit = kDegree});
  visitor.number("opening_tolerance", opening, {.min = 0.0, .max = 0.02});
}

void ArmOffsets::configure(SimulatedRobotOptions& options, const TrialContext& context) const {
  options.sensor_noise.torque_offset += torque;
  options.sensor_noise.position_offset += joint;
  Random draw(context.seeds.shared("jaw opening"));
  options.jaw_offset = opening * draw.uniform(-1.0, 1.0);
}

}  // namespace binpick
