#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/gripper_description.h"
#include "models/mesh_geometry.h"
#include "models/object_model.h"
#include "models/random.h"

namespace binpick {
namespace {

/// The object's extent along the jaws, within the slab that the pads sweep while closing.
Interval width_between_pads(const std::vector<Eigen::Vector3d>& surface, const Grasp& grasp,
                            const GripperDescription& gripper) {
  const Eigen::Isometry3d T_grasp_object = grasp.T_object_grasp.inverse();
  Interval extent{1.0, -1.0};
  for (const Eigen::Vector3d& p_object : surface) {
    const Eigen::Vector3d p = T_grasp_object * p_object;
    if (std::abs(p.x()) > 0.5 * gripper.pad_width || std::abs(p.z()) > 0.5 * gripper.pad_height) {
      continue;
    }
    extent.low = std::min(extent.low, p.y());
    extent.high = std::max(extent.high, p.y());
  }
  return extent;
}

class StoredGrasps : public ::testing::TestWithParam<const char*> {
 protected:
  StoredGrasps() {
    for (const Eigen::Vector3f& p : sample_surface(model_.mesh, 20000, 3).points) {
      surface_.push_back(p.cast<double>());
    }
    surface_.insert(surface_.end(), model_.mesh.vertices.begin(), model_.mesh.vertices.end());
  }

  const ObjectModel model_ = load_known_object(GetParam());
  const GripperDescription gripper_ = load_gripper();
  std::vector<Eigen::Vector3d> surface_;
};
INSTANTIATE_TEST_SUITE_P(Objects, StoredGrasps, ::testing::Values("bottle", "amicelli", "rusk"));

TEST_P(StoredGrasps, LieWithinTheStroke) {
  for (const Grasp& grasp : model_.grasps) {
    EXPECT_TRUE(gripper_.stroke.contains(grasp.pre_opening)) << grasp.name;
    EXPECT_GT(grasp.expected_width, 5 * gripper_.closed_width) << grasp.name;
    EXPECT_NEAR(grasp.T_object_grasp.linear().determinant(), 1.0, 1e-9) << grasp.name;
  }
}

TEST_P(StoredGrasps, ExpectTheWidthThatTheObjectHasThere) {
  for (const Grasp& grasp : model_.grasps) {
    const Interval extent = width_between_pads(surface_, grasp, gripper_);
    EXPECT_NEAR(extent.high - extent.low, grasp.expected_width, 0.004) << grasp.name;
    EXPECT_NEAR(extent.centre(), 0.0, 0.003) << grasp.name;
  }
}

TEST_P(StoredGrasps, TouchNothingBeforeTheJawsClose) {
  const double palm = gripper_.T_flange_tcp.translation().z() - gripper_.body_size.z();
  for (const Grasp& grasp : model_.grasps) {
    const Eigen::Isometry3d T_grasp_object = grasp.T_object_grasp.inverse();
    for (const Eigen::Vector3d& p_object : surface_) {
      const Eigen::Vector3d p = T_grasp_object * p_object;
      const double beside = std::abs(p.y()) - 0.5 * grasp.pre_opening;
      const bool in_finger = beside > 0.0 && beside < gripper_.finger_thickness &&
                             std::abs(p.x()) < 0.5 * gripper_.pad_width &&
                             p.z() < gripper_.tip_beyond_tcp && p.z() > -palm;
      const bool in_palm = p.z() < -palm && std::abs(p.x()) < 0.5 * gripper_.body_size.x() &&
                           std::abs(p.y()) < 0.5 * gripper_.body_size.y();
      ASSERT_FALSE(in_finger) << grasp.name << " at " << p.transpose();
      ASSERT_FALSE(in_palm) << grasp.name << " at " << p.transpose();
    }
  }
}

/// Downward directions in which the object rests stably: minima of the height of its centre of
/// mass, found by rolling downhill from random starts.
std::vector<Eigen::Vector3d> resting_directions(const ObjectModel& model) {
  constexpr int kSteps = 6000;
  std::vector<Eigen::Vector3d> arms;
  for (const TriangleMesh& piece : model.collision) {
    for (const Eigen::Vector3d& v : piece.vertices) arms.push_back(v - model.physics.p_model_com);
  }
  std::vector<Eigen::Vector3d> found;
  Random random(17);
  for (int start = 0; start < 60; ++start) {
    Eigen::Vector3d down = random.unit_vector();
    for (int i = 0; i < kSteps; ++i) {
      // The height is the support function; the lowest point is its gradient.
      Eigen::Vector3d lowest = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& arm : arms) {
        if (down.dot(arm) > down.dot(lowest)) lowest = arm;
      }
      const Eigen::Vector3d tangent = lowest - down.dot(lowest) * down;
      const double step = 0.02 * std::pow(1e-3, static_cast<double>(i) / kSteps);
      down = (down - step * tangent.normalized()).normalized();
    }
    const bool known = std::any_of(found.begin(), found.end(), [&](const Eigen::Vector3d& other) {
      return other.dot(down) > std::cos(0.1);
    });
    if (!known) found.push_back(down);
  }
  return found;
}

constexpr double kSteepest = 30.0 * M_PI / 180.0;  // IJRR 2012, section 5.1

bool is_from_above(const Grasp& grasp, const Eigen::Vector3d& down) {
  return std::acos(std::clamp(grasp.T_object_grasp.linear().col(2).dot(down), -1.0, 1.0)) <
         kSteepest;
}

/// How far the open fingers stay above the plane that the object rests on.
double tip_clearance(const ObjectModel& model, const GripperDescription& gripper,
                     const Grasp& grasp, const Eigen::Vector3d& down) {
  double support = -1e9;
  for (const Eigen::Vector3d& v : model.mesh.vertices) support = std::max(support, down.dot(v));
  double lowest = -1e9;
  for (const double x : {-0.5, 0.5}) {
    for (const double side : {-1.0, 1.0}) {
      for (const double outward : {0.0, gripper.finger_thickness}) {
        const Eigen::Vector3d p_grasp(x * gripper.pad_width,
                                      side * (0.5 * grasp.pre_opening + outward),
                                      gripper.tip_beyond_tcp);
        lowest = std::max(lowest, down.dot(grasp.T_object_grasp * p_grasp));
      }
    }
  }
  return support - lowest;
}

TEST_P(StoredGrasps, SufficeForEveryRestingPose) {
  const std::vector<Eigen::Vector3d> rests = resting_directions(model_);
  EXPECT_GE(rests.size(), 3u);
  for (const Eigen::Vector3d& down : rests) {
    int usable = 0;
    for (const Grasp& grasp : model_.grasps) {
      if (!is_from_above(grasp, down)) continue;
      ++usable;
      EXPECT_GE(tip_clearance(model_, gripper_, grasp, down), 0.004)
          << grasp.name << " resting with " << down.transpose() << " down";
    }
    EXPECT_GE(usable, 4) << "resting with " << down.transpose() << " down";
  }
}

TEST_P(StoredGrasps, CoverLeaningPoses) {
  // Leaning objects rest on others: only the rule of 30 degrees counts.
  Random random(23);
  int uncovered = 0;
  constexpr int kPoses = 2000;
  for (int i = 0; i < kPoses; ++i) {
    const Eigen::Vector3d down = random.unit_vector();
    const bool covered =
        std::any_of(model_.grasps.begin(), model_.grasps.end(),
                    [&](const Grasp& grasp) { return is_from_above(grasp, down); });
    uncovered += covered ? 0 : 1;
  }
  EXPECT_LT(uncovered, kPoses / 20);
}

}  // namespace
}  // namespace binpick
