#include "models/grasp_family.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace binpick {
namespace {

constexpr double kUnitTolerance = 1e-6;
constexpr double kMaxOpening = 0.160;  // stroke of the gripper, m

std::string member_name(const std::string& family, double turn, double shift, double tilt,
                        bool flipped) {
  std::string name = family;
  if (turn != 0.0) name += fmt::format(", turned {:.4g} deg", turn / kDegree);
  if (shift != 0.0) name += fmt::format(", shifted {:.4g} mm", shift / kMillimetre);
  if (tilt != 0.0) name += fmt::format(", tilted {:.4g} deg", tilt / kDegree);
  if (flipped) name += ", flipped";
  return name;
}

}  // namespace

void GraspFamily::visit(ConfigVisitor& visitor) {
  const NumberSpec length{-1.0, 1.0, 1.0};
  const NumberSpec degrees{-360.0, 360.0, kDegree};
  const NumberSpec opening{0.0, kMaxOpening, 1.0};
  visitor.text("name", name, Presence::kRequired);
  visitor.vector("approach", approach, length, Presence::kRequired);
  visitor.vector("jaw", jaw, length, Presence::kRequired);
  visitor.vector("tool_centre", tool_centre, length, Presence::kRequired);
  visitor.number("pre_opening", pre_opening, opening, Presence::kRequired);
  visitor.number("expected_width", expected_width, opening, Presence::kRequired);
  visitor.vector("turn_axis", turn_axis, length);
  visitor.numbers("turns_deg", turns, 0, degrees);
  visitor.numbers("shifts", shifts, 0, length);
  visitor.numbers("tilts_deg", tilts, 0, degrees);
  visitor.boolean("both_wrists", both_wrists);
  if (!visitor.reading()) return;
  const auto is_unit = [](const Eigen::Vector3d& v) {
    return std::abs(v.norm() - 1.0) < kUnitTolerance;
  };
  if (!is_unit(approach)) visitor.problem("approach", "must be a unit vector");
  if (!is_unit(jaw)) visitor.problem("jaw", "must be a unit vector");
  if (!is_unit(turn_axis)) visitor.problem("turn_axis", "must be a unit vector");
  if (std::abs(approach.dot(jaw)) > kUnitTolerance) {
    visitor.problem("jaw", "must be perpendicular to 'approach'");
  }
  if (pre_opening <= expected_width) {
    visitor.problem("pre_opening", "must be larger than 'expected_width'");
  }
  if (turns.empty() || shifts.empty() || tilts.empty()) {
    visitor.problem("", "empty lists leave no grasp; leave the key out instead");
  }
}

std::vector<Grasp> GraspFamily::expand() const {
  // Re-orthogonalised: the file's digits are finite.
  Eigen::Matrix3d R_object_grasp;
  R_object_grasp.col(2) = approach.normalized();
  R_object_grasp.col(0) = jaw.cross(approach).normalized();
  R_object_grasp.col(1) = R_object_grasp.col(2).cross(R_object_grasp.col(0));

  const std::vector<double> half_turns =
      both_wrists ? std::vector<double>{0.0, std::numbers::pi} : std::vector<double>{0.0};
  std::vector<Grasp> grasps;
  for (const double turn : turns) {
    const Eigen::AngleAxisd R_turn(turn, turn_axis.normalized());
    for (const double shift : shifts) {
      const Eigen::Vector3d centre = tool_centre + shift * R_object_grasp.col(0);
      for (const double tilt : tilts) {
        const Eigen::AngleAxisd R_tilt(tilt, Eigen::Vector3d::UnitY());
        for (const double half_turn : half_turns) {
          const Eigen::AngleAxisd R_wrist(half_turn, Eigen::Vector3d::UnitZ());
          Grasp grasp;
          grasp.name = member_name(name, turn, shift, tilt, half_turn != 0.0);
          grasp.T_object_grasp.linear() = R_turn.toRotationMatrix() * R_object_grasp *
                                          R_tilt.toRotationMatrix() * R_wrist.toRotationMatrix();
          grasp.T_object_grasp.translation() = R_turn * centre;
          grasp.pre_opening = pre_opening;
          grasp.expected_width = expected_width;
          grasps.push_back(std::move(grasp));
        }
      }
    }
  }
  return grasps;
}

}  // namespace binpick
