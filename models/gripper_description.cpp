#include "models/gripper_description.h"

#include <cmath>

#include "models/config_visitor.h"
#include "models/object_model.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

Eigen::Matrix3d box_inertia(double mass, const Eigen::Vector3d& size) {
  const Eigen::Vector3d square = size.cwiseAbs2();
  return (mass / 12.0 * (Eigen::Vector3d::Constant(square.sum()) - square)).asDiagonal();
}

/// Inertia about a point that lies `offset` away from the centre of mass.
Eigen::Matrix3d moved(const Eigen::Matrix3d& inertia, double mass, const Eigen::Vector3d& offset) {
  return inertia +
         mass * (offset.squaredNorm() * Eigen::Matrix3d::Identity() - offset * offset.transpose());
}

/// A homogeneous box, as the file describes the housing and a jaw.
struct BoxBody {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  double mass = 0.0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();

  void visit(ConfigVisitor& visitor) {
    visitor.vector("size", size, {0.001, 1.0, 1.0}, Presence::kRequired);
    visitor.number("mass", mass, {0.001, 20.0, 1.0}, Presence::kRequired);
    visitor.vector("com", com, {-1.0, 1.0, 1.0}, Presence::kRequired);
  }
  [[nodiscard]] BodyInertia inertia() const { return {mass, com, box_inertia(mass, size)}; }
};

void check(ConfigVisitor& visitor, const GripperDescription& gripper) {
  if (gripper.closed_width >= gripper.stroke.high) {
    visitor.problem("closed_width", "must be smaller than the stroke");
  }
  if (gripper.tip_beyond_tcp < 0.5 * gripper.pad_height) {
    visitor.problem("tip_beyond_tcp", "must be at least half of 'pad_height': pads end at the tip");
  }
  const double tip = gripper.T_flange_tcp.translation().z() + gripper.tip_beyond_tcp;
  if (std::abs(gripper.body_size.z() + gripper.finger_length - tip) > 1e-9) {
    visitor.problem("finger_length",
                    "must lead from the housing to the tips: body size z + finger_length = "
                    "tcp z + tip_beyond_tcp");
  }
}

}  // namespace

BodyInertia GripperDescription::tool_inertia(double width) const {
  const Eigen::Vector3d p_flange_tcp = T_flange_tcp.translation();
  const Eigen::Vector3d half_width(0.0, 0.5 * width, 0.0);
  const Eigen::Vector3d mirror_y(1.0, -1.0, 1.0);
  const Eigen::Vector3d p_right = T_flange_tcp.linear() * (half_width + jaw.com) + p_flange_tcp;
  const Eigen::Vector3d p_left =
      T_flange_tcp.linear() * mirror_y.cwiseProduct(half_width + jaw.com) + p_flange_tcp;

  const Eigen::Matrix3d mirror = mirror_y.asDiagonal();
  const Eigen::Matrix3d rotation = T_flange_tcp.linear();
  const Eigen::Matrix3d right = rotation * jaw.inertia * rotation.transpose();
  const Eigen::Matrix3d left = rotation * mirror * jaw.inertia * mirror * rotation.transpose();

  BodyInertia tool;
  tool.mass = body.mass + 2.0 * jaw.mass;
  tool.com = (body.mass * body.com + jaw.mass * (p_right + p_left)) / tool.mass;
  tool.inertia = moved(body.inertia, body.mass, body.com - tool.com) +
                 moved(right, jaw.mass, p_right - tool.com) +
                 moved(left, jaw.mass, p_left - tool.com);
  return tool;
}

GripperDescription load_gripper_description(const std::filesystem::path& file) {
  GripperDescription gripper;
  BoxBody body;
  BoxBody jaw;
  Eigen::Vector3d p_flange_tcp = Eigen::Vector3d::Zero();
  read_yaml(file, [&](ConfigVisitor& visitor) {
    const NumberSpec length{0.0, 1.0, 1.0};
    const NumberSpec thickness{0.001, 1.0, 1.0};
    visitor.interval("stroke", gripper.stroke, length, Presence::kRequired);
    visitor.number("max_force", gripper.max_force, {1.0, 1000.0, 1.0}, Presence::kRequired);
    visitor.interval("speed", gripper.speed, {0.0001, 10.0, 1.0}, Presence::kRequired);
    visitor.number("closed_width", gripper.closed_width, length, Presence::kRequired);
    visitor.vector("tcp", p_flange_tcp, {-1.0, 1.0, 1.0}, Presence::kRequired);
    visitor.group(
        "body", [&](ConfigVisitor& fields) { body.visit(fields); }, Presence::kRequired);
    visitor.group(
        "jaw", [&](ConfigVisitor& fields) { jaw.visit(fields); }, Presence::kRequired);
    visitor.number("pad_width", gripper.pad_width, thickness, Presence::kRequired);
    visitor.number("pad_height", gripper.pad_height, thickness, Presence::kRequired);
    visitor.number("finger_length", gripper.finger_length, thickness, Presence::kRequired);
    visitor.number("finger_thickness", gripper.finger_thickness, thickness, Presence::kRequired);
    visitor.number("tip_beyond_tcp", gripper.tip_beyond_tcp, length, Presence::kRequired);
    gripper.T_flange_tcp.translation() = p_flange_tcp;
    gripper.body_size = body.size;
    if (visitor.reading()) check(visitor, gripper);
  });
  gripper.body = body.inertia();
  gripper.jaw = jaw.inertia();
  return gripper;
}

GripperDescription load_gripper() {
  return load_gripper_description(models_directory() / "gripper" / "gripper.yaml");
}

}  // namespace binpick
