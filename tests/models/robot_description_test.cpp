#include "models/robot_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "message_of.h"
#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "models/mesh_import.h"
#include "models/object_model.h"
#include "models/random.h"
#include "models/xml_outline.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

Eigen::Isometry3d flange_of(const RobotDescription& arm, const JointVector& q) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    T = T * arm.joints[i].T_parent_joint *
        Eigen::AngleAxisd(q[static_cast<Eigen::Index>(i)], arm.joints[i].axis);
  }
  return T * arm.T_link7_flange;
}

/// The standard Denavit-Hartenberg form of the arm: a = 0, alpha = 90, -90, -90, 90, 90, -90, 0
/// deg, d = 0, 0, 0.40, 0, 0.39, 0, 0.078 over a shoulder 0.31 above the foot.
Eigen::Isometry3d flange_by_dh(const JointVector& q) {
  const double alpha[] = {90, -90, -90, 90, 90, -90, 0};
  const double d[] = {0, 0, 0.40, 0, 0.39, 0, 0.078};
  Eigen::Isometry3d T(Eigen::Translation3d(0, 0, 0.31));
  for (int i = 0; i < kArmJoints; ++i) {
    T = T * Eigen::AngleAxisd(q[i], Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(0, 0, d[i]) *
        Eigen::AngleAxisd(alpha[i] * M_PI / 180.0, Eigen::Vector3d::UnitX());
  }
  return T;
}

TEST(Lwr, PointsStraightUpAtZero) {
  const Eigen::Isometry3d T = flange_of(load_lwr(), JointVector::Zero());
  EXPECT_LT((T.translation() - Eigen::Vector3d(0, 0, 0.31 + 0.40 + 0.39 + 0.078)).norm(), 1e-12);
  EXPECT_LT((T.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(Lwr, AgreesWithItsDenavitHartenbergForm) {
  const RobotDescription arm = load_lwr();
  Random random(3);
  for (int pose = 0; pose < 200; ++pose) {
    JointVector q;
    for (int i = 0; i < kArmJoints; ++i) {
      q[i] = random.uniform(arm.joints[std::size_t(i)].lower, arm.joints[std::size_t(i)].upper);
    }
    EXPECT_LT((flange_of(arm, q).matrix() - flange_by_dh(q).matrix()).norm(), 1e-9);
  }
}

TEST(Lwr, HasTheDataSheetsLimits) {
  const RobotDescription arm = load_lwr();
  const double range[] = {170, 120, 170, 120, 170, 120, 170};
  const double torque[] = {176, 176, 100, 100, 100, 38, 38};
  const double speed[] = {110, 110, 128, 128, 112.5, 112.5, 112.5};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(arm.joints[i].upper, range[i] * M_PI / 180.0, 1e-12);
    EXPECT_NEAR(arm.joints[i].lower, -range[i] * M_PI / 180.0, 1e-12);
    EXPECT_EQ(arm.joints[i].effort, torque[i]);
    EXPECT_NEAR(arm.joints[i].velocity, speed[i] * M_PI / 180.0, 1e-12);
  }
}

TEST(Lwr, GravityTorquesAreTheIdentifiedOnes) {
  // Stretched out horizontally, without a tool: g2 = -47.3 Nm and g4 = 13.4 Nm follow from the base
  // parameters of Gaz, Flacco and De Luca (ICRA 2016).
  const RobotDescription arm = load_lwr();
  JointVector q = JointVector::Zero();
  q[1] = M_PI / 2;
  const auto potential = [&](const JointVector& at) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    double energy = 0.0;
    for (std::size_t i = 0; i < 7; ++i) {
      T = T * arm.joints[i].T_parent_joint *
          Eigen::AngleAxisd(at[static_cast<Eigen::Index>(i)], arm.joints[i].axis);
      energy += 9.81 * arm.links[i].inertia.mass * (T * arm.links[i].inertia.com).z();
    }
    return energy;
  };
  const auto gravity_torque = [&](int joint) {
    const double step = 1e-6;
    JointVector more = q;
    JointVector less = q;
    more[joint] += step;
    less[joint] -= step;
    return (potential(more) - potential(less)) / (2 * step);
  };
  EXPECT_NEAR(gravity_torque(1), -47.3, 0.1);
  EXPECT_NEAR(gravity_torque(3), 13.4, 0.1);
  double mass = 0.0;
  for (const LinkDescription& link : arm.links) mass += link.inertia.mass;
  EXPECT_NEAR(mass, 14.4, 1e-9);
  EXPECT_NEAR(arm.base.inertia.mass, 1.6, 1e-9);
}

TEST(Lwr, EveryLinkHasClosedVisualMeshesAndCollisionShapes) {
  const RobotDescription arm = load_lwr();
  std::vector<std::filesystem::path> files;
  const auto collect = [&](const LinkDescription& link) {
    EXPECT_FALSE(link.visuals.empty()) << link.name;
    EXPECT_FALSE(link.collisions.empty()) << link.name;
    for (const LinkShape& shape : link.visuals) {
      files.push_back(std::get<LinkShape::Mesh>(shape.geometry).file);
    }
  };
  collect(arm.base);
  for (const LinkDescription& link : arm.links) collect(link);
  for (const TriangleMesh& mesh : import_meshes(files)) {
    EXPECT_TRUE(is_watertight(mesh));
    EXPECT_GT(volume(mesh), 0.0);
  }
}

class BrokenUrdf : public ::testing::Test {
 protected:
  BrokenUrdf() : text_(read_whole_file(models_directory() / "lwr" / "lwr.urdf")) {
    std::filesystem::copy(models_directory() / "lwr" / "meshes", folder_.path() / "meshes");
  }

  std::string message_for(const std::string& urdf) {
    const auto file = folder_.write("arm.urdf", urdf);
    return message_of<InputError>([&] { static_cast<void>(load_robot_description(file)); });
  }
  std::string message_with(const std::string& from, const std::string& to) {
    std::string text = text_;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return message_for(text);
  }

  TemporaryFolder folder_;
  std::string text_;
};

TEST_F(BrokenUrdf, UnbrokenItLoads) {
  EXPECT_EQ(load_robot_description(folder_.write("arm.urdf", text_)).name, "lwr");
}

TEST_F(BrokenUrdf, XmlErrorsHaveLineAndColumn) {
  EXPECT_THAT(message_for(""), HasSubstr("arm.urdf:1:1: "));
  EXPECT_THAT(message_for("<robot>\n  <link>\n</robot>"), HasSubstr("arm.urdf:3:1: "));
  EXPECT_THAT(message_for("<robot>\n <link name='a>\n</robot>"), HasSubstr("arm.urdf:2:8: "));
  EXPECT_THAT(message_for("<robot name='a'>"), HasSubstr("arm.urdf:1:1: "));
  EXPECT_THAT(message_for("<!DOCTYPE r [<!ENTITY a 'b'>]><robot/>"), HasSubstr("entities"));
}

TEST_F(BrokenUrdf, DeepNestingIsRefusedBeforeItIsParsed) {
  std::string text = "<robot name='deep'>";
  for (int i = 0; i < 200000; ++i) text += "<a>";
  EXPECT_THAT(message_for(text), HasSubstr("deeper than"));
  EXPECT_THAT(message_for(std::string(XmlOutline::kMaxBytes + 1, ' ')), HasSubstr("larger than"));
}

TEST_F(BrokenUrdf, WhatIsNoArmIsRefusedWithItsPlace) {
  EXPECT_THAT(message_with("<joint name=\"joint_3\" type=\"revolute\">",
                           "<joint name=\"joint_3\" type=\"prismatic\">"),
              HasSubstr("joint 'joint_3' must be revolute"));
  EXPECT_THAT(message_with("<mass value=\"2.69\"/>", "<mass value=\"-2.69\"/>"),
              HasSubstr("link 'link_1' needs a positive mass"));
  EXPECT_THAT(message_with("ixx=\"0.0168\"", "ixx=\"1.0168\""), HasSubstr("that no body has"));
  EXPECT_THAT(message_with("<parent link=\"link_3\"/>", "<parent link=\"link_2\"/>"),
              HasSubstr("exactly one joint"));
  EXPECT_THAT(message_with("<child link=\"link_4\"/>", "<child link=\"nowhere\"/>"),
              HasSubstr("arm.urdf"));
  EXPECT_THAT(message_with("effort=\"176\"", "effort=\"nan\""), HasSubstr("arm.urdf"));
  EXPECT_THAT(message_with("xyz=\"0 0 0.11\"", "xyz=\"0 0 inf\""), HasSubstr("arm.urdf"));
  EXPECT_THAT(message_with("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>"),
              HasSubstr("unit vector"));
}

TEST_F(BrokenUrdf, MeshesOutsideTheFolderAreRefused) {
  for (const char* name : {"/etc/passwd", "../arm.urdf", "package://lwr/base.obj",
                           "file:///etc/passwd", "meshes/absent.obj"}) {
    EXPECT_THAT(message_with("meshes/base.obj", name), HasSubstr("link 'base': mesh")) << name;
  }
  std::filesystem::create_symlink("/etc/passwd", folder_.path() / "meshes" / "linked.obj");
  EXPECT_THAT(message_with("meshes/base.obj", "meshes/linked.obj"), HasSubstr("outside"));
}

TEST_F(BrokenUrdf, AMissingFileIsNamed) {
  EXPECT_THAT(message_of<InputError>(
                  [] { static_cast<void>(load_robot_description("/nowhere/arm.urdf")); }),
              HasSubstr("/nowhere/arm.urdf"));
}

}  // namespace
}  // namespace binpick
