#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "control/inverse_kinematics.h"

namespace binpick {

/// Why the tool cannot go straight from the arm's posture `q` to `T_world_goal`, turning about one
/// axis; nothing if it can. Postures are sought every 2 cm or 0.1 rad, each within 0.5 rad of the
/// one before: a line on which the arm would have to change its branch is kFarFromSeed. About 60 us
/// per point; allocates nothing.
[[nodiscard]] std::optional<IkFailure> line_failure(const InverseKinematics& kinematics,
                                                    const Eigen::Isometry3d& T_world_start,
                                                    const Eigen::Isometry3d& T_world_goal,
                                                    const JointVector& q) noexcept;

}  // namespace binpick
