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
fault recognizer-without-penalty recognition/acceptance_function.cpp \
  's/(static_cast<float>\(counts\.occluding\) > most)\)/\1 + 1e9f)/' \
  recognition_tests 'AcceptanceFunction.APoseThatSticksOutIsRejectedByThePenaltyAlone'

# Runs and their statistics.
fault pause-counts-as-time experiments/runner.cpp \
  's/if \(pause < kPause\) return;/if (pause < 1000 * kPause) return;/' \
  experiments_tests 'ProgramFaults.APausedRunLosesNoTrialToTheTimeLimit'
fault stopping-with-plain-intervals experiments/stopping_rule.cpp \
  's/if \(covers_enough\(\)\) return;/if (covers_enough() || most > 0) return;/' \
  experiments_tests 'StoppingRule/SequentialPlans.CoverEveryRate*'
fault gate-cries-wolf experiments/success_gate.h \
  's/kFalseAlarms = 0\.01/kFalseAlarms = 0.05/' \
  experiments_tests 'SuccessGate/SuccessGates.RaiseAFalseAlarmInAtMostOnePercent*'
fault gate-sleeps experiments/success_gate.h \
  's/kMisses = 0\.1/kMisses = 0.25/' \
  experiments_tests 'SuccessGate/SuccessGates.SeeADropOfFifteenPointsInNineOfTenCases*'

# Control.
fault spring-in-world-axes control/cartesian_impedance.cpp \
  's/twist_transform\(target\.T_world_tcp\.linear\(\),/twist_transform(Eigen::Matrix3d::Identity(),/' \
  control_tests 'CartesianImpedance.StaticStiffnessIsAsAskedOnEveryAxis'
fault damping-drives control/cartesian_impedance.cpp \
  's/(const Vector6 damping = )D\.lazyProduct/\1-D.lazyProduct/' \
  control_physics_tests 'PassivityPhysics.RigidArmWithPostureLimitsAndSwitchedStiffness'
fault damping-of-a-unit-mass control/damping_design.cpp \
  's/inverse_root<N>\(B\)\)/Matrix::Identity())/' \
  control_tests 'CartesianImpedance.EveryModeHasTheCommandedDampingRatio'
fault gravity-missing control/arm_controller.cpp \
  's/limiter_\.limit\(dynamics\(\)\.gravity, control_torques/limiter_.limit(JointVector::Zero(), control_torques/' \
  control_tests 'ArmController.HoldsTheFirstPoseUntilTold'
fault coriolis-reversed control/arm_model.cpp \
  's/(result\.coriolis\[row\] = )dot/\1-dot/' \
  control_tests 'ArmModel.MassRateIsCoriolisPlusItsTranspose'
fault observer-twice-as-fast control/disturbance_observer.cpp \
  's/-std::expm1\(-options_\.gain/-std::expm1(-2.0 * options_.gain/' \
  control_tests 'DisturbanceObserver.FollowsAJointTorqueWithItsTimeConstantAlone'
fault observer-coriolis-reversed control/disturbance_observer.cpp \
  's/bias = dynamics\.coriolis \+ dynamics\.gravity/bias = dynamics.gravity - dynamics.coriolis/' \
  control_tests 'DisturbanceObserver.SeesNothingDuringAFastFreeMotion'
fault null-space-not-consistent control/operational_space.cpp \
  '1i #include <Eigen/Cholesky>
  s/const Vector6 wrench = wrench_of\(tau\);/const Vector6 wrench = (J_ * J_.transpose()).llt().solve(J_ * tau);/' \
  control_tests 'CartesianImpedance.NullSpaceDoesNotAccelerateTheTool'
fault posture-makes-energy control/cartesian_impedance.cpp \
  's/const double valve = std::min\(.*/const double valve = 1.0;/;s/posture_store_ - null_space/posture_store_ - 0.0 * null_space/' \
  control_physics_tests 'PassivityPhysics.RigidArmWithPostureLimitsAndSwitchedStiffness'
fault stiffening-for-free control/cartesian_impedance.cpp \
  's/if \(change \* price > energy_store_\)/if (false)/' \
  control_physics_tests 'PassivityPhysics.SwitchingTheStiffnessOfAStretchedSpringGivesNothingAway'
fault torque-feedback-reversed control/elastic_joints.cpp \
  's/\(1\.0 - reduction_\)/(reduction_ - 1.0)/' \
  control_physics_tests 'ObserverPhysics.ToolForcesArriveWithTheTimeConstant'
fault deflection-by-gravity-alone control/arm_controller.cpp \
  's/if \(hold_ \|\| starting_\) return tau;/return tau;/' \
  control_physics_tests 'Poses/StiffnessPhysics.ElasticJointsLeaveTheStiffnessAsAsked/0'
fault feed-forward-missing control/cartesian_impedance.cpp \
  's/lag_world = target\.twist - twist;/lag_world = -twist;/' \
  control_physics_tests 'DampingPhysics.VelocityFeedForwardRemovesTheTrackingLag'
fault stop-keeps-the-spring control/arm_controller.cpp \
  's/T_world_equilibrium_ = dynamics\(\)\.T_world_tcp;/T_world_equilibrium_ = T_world_equilibrium_;/' \
  control_tests 'ArmController.StopCancelsTheSpringAndEndsTheMotion'
fault jumps-followed-at-once control/arm_controller.cpp \
  's/if \(!far\)/if (!far || true)/' \
  control_tests 'ArmController.ASetPointThatJumpsIsApproached'
fault speed-barrier-missing control/arm_controller.cpp \
  's/const JointVector tau = within_joint_limits\(\*limited, dt\);/const JointVector tau = *limited;/' \
  control_physics_tests 'LimitsPhysics.ALineThatAsksJointsForTooMuchBreaksNoLimit'
fault speed-barrier-without-look-ahead control/joint_limit_barrier.cpp \
  's/jerk \* \(std::sqrt/1e3 * jerk * (std::sqrt/' \
  control_physics_tests 'LimitsPhysics.*BreaksNoLimit'
fault barrier-keeps-a-tool-bouncing control/joint_limit_barrier.cpp \
  's/(backward && motion\.touched)\)/\1 \&\& false)/' \
  control_physics_tests 'Joints/ForcePhysics.EightCasesComeInTheirOrder/rigid'
fault damping-without-deflection control/arm_controller.cpp \
  's/cartesian\.joint_compliance = .*;//' \
  control_physics_tests 'DampingPhysics.ElasticJointsShowTheCommandedRatio'
fault sensor-offset-added control/arm_controller.cpp \
  's/state\.tau - sensor_offset_/state.tau + sensor_offset_/' \
  control_physics_tests 'ObserverPhysics.CalibrationFindsTheSensorsOffsets'
fault retreat-into-the-obstacle control/collision_reaction.cpp \
  's/options_\.retreat_distance \* direction/-options_.retreat_distance * direction/' \
  control_tests 'CollisionReaction.RetreatLeavesTheObstacle'
fault wrist-not-flipped control/inverse_kinematics.cpp \
  's/std::swap\(wrist\.upright\[0\], wrist\.flipped\[0\]\);//' \
  control_tests 'InverseKinematicsTest.EveryBranchReachesThePoseWithinLimitsAtTheWantedSwivel'
fault speed-barrier-learns-late control/arm_controller.cpp \
  's/observer_\.unfiltered\(\)/status_.residual/' \
  experiments_tests 'ContactTrial.NoBlowDrivesARigidJointBeyondItsLimits'
fault drives-out-of-step sim/elastic_drives.cpp \
  's/lead_ = 0\.5 \* \(duration - h\);/lead_ = 0.0;/' \
  sim_tests 'ElasticDrives.LongStepsNeitherDampNorDriveTheSprings'
