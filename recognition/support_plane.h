#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "models/random.h"
#include "recognition/scene_octree.h"

namespace binpick {

/// A plane on which (or in front of which) the objects are, e.g. a table: normal . p = offset, the
/// normal pointing to the side of the sensor.
struct SupportPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;
  double tolerance = 0.0;  ///< points up to this height belong to the plane, m

  /// The slow bend of the sensor's depth over the plane (a Kinect bows by 2-3 mm): its height above
  /// the plane is bow . (1, a, b, a^2, a b, b^2) with a, b along `axes` from `centre`, limited to
  /// `reach`.
  Eigen::Matrix<double, 6, 1> bow = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Vector2d reach = Eigen::Vector2d::Zero();

  /// Height above the plane, the bow taken off, m.
  [[nodiscard]] double height(const Eigen::Vector3d& p) const;
};

/// SupportPlane::height in single precision, for many points.
class PlaneHeight {
 public:
  explicit PlaneHeight(const SupportPlane& plane);

  [[nodiscard]] float operator()(float x, float y, float z) const noexcept {
    const float level = normal_.x() * x + normal_.y() * y + normal_.z() * z - offset_;
    const float a =
        limited(axis_a_.x() * x + axis_a_.y() * y + axis_a_.z() * z - middle_.x(), reach_.x());
    const float b =
        limited(axis_b_.x() * x + axis_b_.y() * y + axis_b_.z() * z - middle_.y(), reach_.y());
    return level -
           (bow_[0] + a * (bow_[1] + a * bow_[3] + b * bow_[4]) + b * (bow_[2] + b * bow_[5]));
  }

 private:
  static float limited(float value, float reach) noexcept {
    const float below = value < reach ? value : reach;
    return below > -reach ? below : -reach;
  }

  Eigen::Vector3f normal_;
  Eigen::Vector3f axis_a_;
  Eigen::Vector3f axis_b_;
  Eigen::Vector2f middle_;
  Eigen::Vector2f reach_;
  Eigen::Matrix<float, 6, 1> bow_;
  float offset_;
};

/// What a plane must be to count as support and not as an object's face.
struct SupportPlaneOptions {
  double least_area = 0.0;    ///< m^2; several times the largest face of any model
  double most_behind = 0.02;  ///< share of points seen through the plane's outline
  int most_planes = 3;        ///< e.g. a table, the floor and a wall
  int samples = 400;          ///< RANSAC draws per plane
};

/// Finds the support planes among the points of S* by RANSAC (IJRR 2012, section 6.3), largest
/// first. The sensor is at the origin. A plane with points behind it inside its own outline is
/// rejected: the coplanar tops of two boxes look like a table until one sees past them.
/// O(points) besides at most `samples` draws that are judged by a fixed number of points; on up to
/// `jobs` threads. The same for the same seed.
[[nodiscard]] std::vector<SupportPlane> find_support_planes(const SceneOctree& octree,
                                                            const SupportPlaneOptions& options,
                                                            Seed seed, int jobs = 1);

}  // namespace binpick
