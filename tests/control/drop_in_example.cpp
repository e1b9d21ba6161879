// Control as a library: what passes between a robot and `binpick::control` is (joint state, dt) in
// and joint torques out. Here the robot is the simulated arm; a real one would take its place.
#include <cstdio>

#include "control/arm_controller.h"
#include "control/cartesian_trajectory.h"
#include "scenes/scene.h"
#include "sim/simulated_robot.h"
#include "sim/world.h"

using namespace binpick;

int main() {
  // The robot: a simulated cell behind the boundary.
  const auto cell =
      make_world_template(load_scene(BINPICK_SOURCE_DIR "/scenes/single_bottle.yaml"));
  World world(cell, centre_physics(cell->parts.objects));
  SimulatedRobot robot(world, nullptr, {});

  // The controller: the arm's model from its description, 2000 N/m, soft along the jaws.
  const ArmModel model(load_lwr(), load_gripper());
  ArmController controller(model);
  controller.set_stiffness((Vector6() << 2000, 200, 2000, 200, 200, 200).finished());

  // A line of 10 cm upwards and 1 s of rest; stop if something is hit.
  RobotState state = robot.state();
  const Eigen::Isometry3d start = model.forward_kinematics(state.joints.q);
  const CartesianTrajectory line(start, Eigen::Translation3d(0.0, 0.0, 0.1) * start);
  RobotCommand command{.gripper = {.width = state.gripper.width}};
  bool stopped = false;
  for (double t = 0.0; t < line.duration() + 1.0; t += kControlPeriod) {
    if (!stopped) controller.set_cartesian_target(line.sample(t));
    command.tau = controller.tick(state.joints, kControlPeriod);
    state = robot.exchange(command);
    if (!stopped && controller.status().collision) {
      controller.stop();
      stopped = true;
    }
  }
  const Eigen::Vector3d error =
      controller.status().T_world_tcp.translation() - line.goal().translation();
  std::printf("%s %.2f mm from the goal\n", stopped ? "stopped," : "arrived,", 1e3 * error.norm());
  return !stopped && error.norm() < 0.002 ? 0 : 1;
}
