# Planted faults, one call per fault: fault NAME FILE SED TARGET FILTER (see scripts/planted_faults).
# What each one means, and why that test must notice: tests/planted_faults.md.

fault gripper-quarter-force sim/gripper_servo.cpp \
  's/std::clamp\(command_\.force, 0\.0, max_force_\)/0.25 * &/' \
  sim_tests '*GripForce.IsTheCommandedOneOnBothPads*'
fault camera-tilted sim/depth_camera.cpp \
  's/(image\.T_world_camera = camera\.T_world_camera\(\));/\1 * Eigen::AngleAxisd(0.034907, Eigen::Vector3d::UnitX());/' \
  sim_tests 'PileView.PointsOfTheTableLieOnTheTable'
fault stiffness-axes-swapped control/cartesian_impedance.cpp \
  's/ClippedSpring translation\(stiffness_\.head<3>\(\)/ClippedSpring translation(Eigen::Vector3d(stiffness_[1], stiffness_[0], stiffness_[2])/' \
  control_tests 'CartesianImpedance.StaticStiffnessIsAsAskedOnEveryAxis'
fault observer-silent control/disturbance_observer.cpp \
  's/^( *residual_ \+= )/\1 0.0 * /' \
  control_tests 'DisturbanceObserver.EstimatesAToolWrench'
