#include "models/robot_description.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <fstream>
#include <iterator>
#include <mutex>
#include <set>

#include "models/errors.h"
#include "models/object_model.h"
#include "models/resource_path.h"
#include "models/xml_outline.h"

namespace binpick {
namespace {

std::string read_text(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("{}: no such file; give a URDF", file.string()));
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  if (!stream) throw IoError(fmt::format("{}: cannot be read", file.string()));
  return text;
}

/// urdfdom reports through a global handler: collects what it says while in scope.
class UrdfdomMessages : public console_bridge::OutputHandler {
 public:
  UrdfdomMessages() : lock_(mutex()) { console_bridge::useOutputHandler(this); }
  ~UrdfdomMessages() override { console_bridge::restorePreviousOutputHandler(); }
  UrdfdomMessages(const UrdfdomMessages&) = delete;
  UrdfdomMessages& operator=(const UrdfdomMessages&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error_.empty()) {
      first_error_ = text.substr(0, text.find('\n'));
    }
  }
  [[nodiscard]] const std::string& first_error() const { return first_error_; }

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }

  std::lock_guard<std::mutex> lock_;
  std::string first_error_;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& text, const std::string& name) {
  UrdfdomMessages messages;
  urdf::ModelInterfaceSharedPtr model;
  std::string problem;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (!messages.first_error().empty()) problem = messages.first_error();
  if (model == nullptr || !problem.empty()) {
    throw InputError(fmt::format("{}: not a valid URDF: {}; correct it", name,
                                 problem.empty() ? "no robot" : problem));
  }
  return model;
}

Eigen::Vector3d to_eigen(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Eigen::Isometry3d to_eigen(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  T.translation() = to_eigen(pose.position);
  return T;
}

/// Turns urdfdom's tree into the arm, refusing whatever is not one.
class ArmBuilder {
 public:
  ArmBuilder(const urdf::ModelInterface& model, const XmlOutline& outline,
             std::filesystem::path directory)
      : model_(model), outline_(outline), directory_(std::move(directory)) {}

  [[nodiscard]] RobotDescription build() const {
    RobotDescription arm;
    arm.name = model_.getName();
    urdf::LinkConstSharedPtr link = model_.getRoot();
    arm.base = convert(*link);
    for (std::size_t i = 0; i < arm.joints.size(); ++i) {
      const urdf::JointConstSharedPtr joint = only_joint_of(*link, urdf::Joint::REVOLUTE);
      arm.joints[i] = convert(*joint);
      link = model_.getLink(joint->child_link_name);
      arm.links[i] = convert(*link);
      require(arm.links[i].inertia.mass > 0.0, "link", link->name,
              "moves and needs an <inertial> with a mass");
    }
    const urdf::JointConstSharedPtr flange = only_joint_of(*link, urdf::Joint::FIXED);
    arm.T_link7_flange = to_eigen(flange->parent_to_joint_origin_transform);
    require(arm.T_link7_flange.matrix().allFinite(), "joint", flange->name,
            "has an origin that is not finite");
    const urdf::LinkConstSharedPtr end = model_.getLink(flange->child_link_name);
    require(end->child_joints.empty(), "link", end->name, "is the flange and must be the last one");
    require(!end->inertial && end->visual_array.empty() && end->collision_array.empty(), "link",
            end->name, "is the flange, a mere frame; give body and shape to the link before it");
    return arm;
  }

 private:
  void require(bool condition, std::string_view tag, const std::string& name,
               std::string_view what) const {
    if (!condition) {
      throw InputError(fmt::format("{}: {} '{}' {}", outline_.locate(tag, name), tag, name, what));
    }
  }

  [[nodiscard]] urdf::JointConstSharedPtr only_joint_of(const urdf::Link& link, int type) const {
    require(link.child_joints.size() == 1, "link", link.name,
            "must carry exactly one joint: an arm is a base, seven revolute joints in a row and a "
            "fixed flange");
    const urdf::JointConstSharedPtr joint = link.child_joints.front();
    require(joint->type == type, "joint", joint->name,
            type == urdf::Joint::FIXED ? "must be fixed: it carries the flange"
                                       : "must be revolute: the arm has seven of them");
    return joint;
  }

  [[nodiscard]] JointDescription convert(const urdf::Joint& joint) const {
    require(joint.limits != nullptr, "joint", joint.name, "needs a <limit>");
    require(!joint.mimic, "joint", joint.name, "must not mimic another one");
    JointDescription description;
    description.name = joint.name;
    description.T_parent_joint = to_eigen(joint.parent_to_joint_origin_transform);
    description.axis = to_eigen(joint.axis);
    description.lower = joint.limits->lower;
    description.upper = joint.limits->upper;
    description.velocity = joint.limits->velocity;
    description.effort = joint.limits->effort;
    require(description.T_parent_joint.matrix().allFinite(), "joint", joint.name,
            "has an origin that is not finite");
    require(std::abs(description.axis.norm() - 1.0) < 1e-6, "joint", joint.name,
            "needs a unit vector as axis");
    require(std::isfinite(description.lower) && std::isfinite(description.upper) &&
                description.lower < description.upper,
            "joint", joint.name, "needs finite limits with lower < upper");
    require(std::isfinite(description.velocity) && description.velocity > 0.0, "joint", joint.name,
            "needs a positive velocity limit");
    require(std::isfinite(description.effort) && description.effort > 0.0, "joint", joint.name,
            "needs a positive effort limit");
    return description;
  }

  [[nodiscard]] LinkDescription convert(const urdf::Link& link) const {
    LinkDescription description;
    description.name = link.name;
    if (link.inertial) description.inertia = convert_inertia(link);
    for (const auto& visual : link.visual_array) {
      require(visual->geometry != nullptr, "link", link.name, "has a <visual> without geometry");
      LinkShape shape = convert(*visual->geometry, visual->origin, link.name);
      if (visual->material) {
        const urdf::Color& c = visual->material->color;
        shape.colour = {c.r, c.g, c.b, c.a};
      }
      description.visuals.push_back(std::move(shape));
    }
    for (const auto& collision : link.collision_array) {
      require(collision->geometry != nullptr, "link", link.name,
              "has a <collision> without geometry");
      description.collisions.push_back(convert(*collision->geometry, collision->origin, link.name));
    }
    return description;
  }

  [[nodiscard]] BodyInertia convert_inertia(const urdf::Link& link) const {
    const urdf::Inertial& given = *link.inertial;
    const Eigen::Isometry3d T_link_com = to_eigen(given.origin);
    Eigen::Matrix3d inertia;
    inertia << given.ixx, given.ixy, given.ixz,  //
        given.ixy, given.iyy, given.iyz,         //
        given.ixz, given.iyz, given.izz;
    require(std::isfinite(given.mass) && given.mass > 0.0, "link", link.name,
            "needs a positive mass");
    require(inertia.allFinite() && T_link_com.matrix().allFinite(), "link", link.name,
            "has an inertia that is not finite");
    // A body's principal moments obey the triangle inequality.
    const Eigen::Vector3d principal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly)
            .eigenvalues();
    const double slack = 1e-9 + 1e-6 * principal.z();
    require(principal.x() > 0.0 && principal.x() + principal.y() + slack >= principal.z(), "link",
            link.name,
            "has an inertia that no body has: moments must be positive and none larger "
            "than the sum of the others");
    return {given.mass, T_link_com.translation(),
            T_link_com.linear() * inertia * T_link_com.linear().transpose()};
  }

  [[nodiscard]] LinkShape convert(const urdf::Geometry& geometry, const urdf::Pose& origin,
                                  const std::string& link) const {
    LinkShape shape;
    shape.T_link_shape = to_eigen(origin);
    require(shape.T_link_shape.matrix().allFinite(), "link", link,
            "has a shape whose origin is not finite");
    const auto size = [&](double value) {
      require(std::isfinite(value) && value > 0.0, "link", link,
              "has a shape whose size is not positive");
      return value;
    };
    if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      shape.geometry = LinkShape::Sphere{size(sphere->radius)};
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      shape.geometry =
          LinkShape::Box{Eigen::Vector3d(size(box->dim.x), size(box->dim.y), size(box->dim.z))};
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      shape.geometry = LinkShape::Cylinder{size(cylinder->radius), size(cylinder->length)};
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
      require(mesh->scale.x == 1.0 && mesh->scale.y == 1.0 && mesh->scale.z == 1.0, "link", link,
              "scales a mesh; store it in metres instead");
      shape.geometry = LinkShape::Mesh{mesh_file(mesh->filename, link)};
    } else {
      require(false, "link", link, "has a shape of an unknown kind");
    }
    return shape;
  }

  [[nodiscard]] std::filesystem::path mesh_file(const std::string& name,
                                                const std::string& link) const {
    try {
      return resolve_inside(directory_, name);
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{}: link '{}': mesh {}", outline_.locate("link", link), link, error.what()));
    }
  }

  const urdf::ModelInterface& model_;
  const XmlOutline& outline_;
  std::filesystem::path directory_;
};

}  // namespace

RobotDescription load_robot_description(const std::filesystem::path& urdf) {
  const std::string text = read_text(urdf);
  const XmlOutline outline(text, urdf.string());
  const urdf::ModelInterfaceSharedPtr model = parse(text, urdf.string());
  return ArmBuilder(*model, outline, urdf.parent_path()).build();
}

RobotDescription load_lwr() {
  return load_robot_description(models_directory() / "lwr" / "lwr.urdf");
}

}  // namespace binpick
