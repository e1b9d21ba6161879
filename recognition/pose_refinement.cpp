#include "recognition/pose_refinement.h"

#include <ceres/tiny_solver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace binpick {
namespace {

constexpr float kLikeNormal = 0.7f;

struct Correspondence {
  Eigen::Vector3f p_camera;  // of the model
  Eigen::Vector3f normal;    // of the model
  Eigen::Vector3f q_camera;  // of the scene
};

/// Calls `visit` for each of the first `count` model points that face the sensor and see a scene
/// point within `epsilon` with a similar normal.
template <class Visit>
void for_each_correspondence(const ObservedScene& scene, const RecognitionModel& model,
                             const Eigen::Isometry3f& T_camera_model, float epsilon,
                             std::size_t count, const Visit& visit) {
  const TestPoints& points = model.test_points;
  const Projection& projection = scene.projection();
  const Eigen::Matrix3f R = T_camera_model.linear();
  const Eigen::Vector3f t = T_camera_model.translation();
  for (std::size_t i = 0; i < std::min(count, points.size()); ++i) {
    const Eigen::Vector3f p = R * points.p(i) + t;
    const Eigen::Vector3f n = R * points.n(i);
    if (n.dot(p) >= 0.0f) continue;
    const int index = projection.pixel(p);
    if (index < 0) continue;
    const ScenePixel& pixel = scene.pixel(index);
    if (!(pixel.depth > 0.0f) || (pixel.flags & ScenePixel::kSupport) != 0) continue;
    if ((pixel.flags & ScenePixel::kNormal) != 0 && n.dot(pixel.normal()) < kLikeNormal) continue;
    const Eigen::Vector3f q = projection.point(index, pixel.depth);
    if (std::abs(n.dot(q - p)) > epsilon) continue;
    visit(Correspondence{p, n, q});
  }
}

/// The rotation vector's rotation about `centre`, then a translation.
Eigen::Isometry3d motion_about(const Eigen::Vector3d& centre, const double* motion) {
  const Eigen::Vector3d w(motion[0], motion[1], motion[2]);
  const double angle = w.norm();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (angle > 0.0) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = centre + Eigen::Vector3d(motion[3], motion[4], motion[5]) - T.linear() * centre;
  return T;
}

/// How a rotation vector's change turns the rotated frame, seen from outside: the left Jacobian of
/// SO(3).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  Eigen::Matrix3d cross;
  cross << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() + 0.5 * cross;
  return Eigen::Matrix3d::Identity() + (1.0 - std::cos(angle)) / (angle * angle) * cross +
         (angle - std::sin(angle)) / std::pow(angle, 3) * cross * cross;
}

/// Point-to-plane residuals of a small motion about `centre`, for Ceres.
class PointToPlane {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  PointToPlane(std::vector<Correspondence> pairs, const Eigen::Vector3d& centre, double scale)
      : pairs_(std::move(pairs)), centre_(centre), scale_(scale) {}

  [[nodiscard]] int NumResiduals() const { return static_cast<int>(pairs_.size()); }

  /// Cauchy's loss as a residual: sqrt(log(1 + (r / s)^2)) with the sign of r. Its square is the
  /// robust cost. `jacobian` is column-major, residuals x 6.
  bool operator()(const double* motion, double* residuals, double* jacobian) const {
    const Eigen::Isometry3d T = motion_about(centre_, motion);
    const Eigen::Matrix3d turn_by_parameter =
        left_jacobian(Eigen::Vector3d(motion[0], motion[1], motion[2]));
    const Eigen::Vector3d moved_centre = T * centre_;
    const auto rows = static_cast<Eigen::Index>(pairs_.size());
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Correspondence& pair = pairs_[static_cast<std::size_t>(i)];
      const Eigen::Vector3d n = T.linear() * pair.normal.cast<double>();
      const Eigen::Vector3d q = pair.q_camera.cast<double>();
      const double r = n.dot(T * pair.p_camera.cast<double>() - q) / scale_;
      const double loss = std::sqrt(std::log1p(r * r));
      residuals[i] = std::copysign(loss, r);
      if (jacobian == nullptr) continue;
      const double slope = loss > 1e-9 ? std::abs(r) / ((1.0 + r * r) * loss) : 1.0;
      // A further turn w about the moved centre c turns n and p together, which changes
      // n.(p - q) by w.(n x (c - q)).
      const Eigen::Vector3d by_turn = turn_by_parameter.transpose() * n.cross(moved_centre - q);
      for (int k = 0; k < 3; ++k) {
        jacobian[i + rows * k] = slope / scale_ * by_turn[k];
        jacobian[i + rows * (k + 3)] = slope / scale_ * n[k];
      }
    }
    return true;
  }

 private:
  std::vector<Correspondence> pairs_;
  Eigen::Vector3d centre_;
  double scale_;
};

}  // namespace

namespace {

using Vector6f = Eigen::Matrix<float, 6, 1>;
using Matrix6f = Eigen::Matrix<float, 6, 6>;

/// Normal equations of the point-to-plane distances for a small motion about the model's centre.
/// Turns are measured in radii, so that all six unknowns are lengths.
struct NormalEquations {
  Matrix6f information = Matrix6f::Zero();
  Vector6f right = Vector6f::Zero();
  int pairs = 0;
};

NormalEquations normal_equations(const ObservedScene& scene, const RecognitionModel& model,
                                 const Eigen::Isometry3f& T, float epsilon, std::size_t count) {
  NormalEquations equations;
  const Eigen::Vector3f centre = T * model.centre;
  const float inverse_radius = 2.0f / model.diameter;
  for_each_correspondence(scene, model, T, epsilon, count, [&](const Correspondence& pair) {
    const Eigen::Vector3f arm = (pair.p_camera - centre) * inverse_radius;
    const Eigen::Vector3f turn = arm.cross(pair.normal);
    Vector6f row;
    row << turn.x(), turn.y(), turn.z(), pair.normal;
    equations.information.noalias() += row * row.transpose();
    equations.right += row * pair.normal.dot(pair.q_camera - pair.p_camera);
    ++equations.pairs;
  });
  return equations;
}

}  // namespace

Eigen::Isometry3f move_along(const RecognitionModel& model, const Eigen::Isometry3f& T_camera_model,
                             const Vector6f& motion, float length) {
  const Eigen::Vector3f centre = T_camera_model * model.centre;
  const Eigen::Vector3f turn = motion.head<3>() * (2.0f * length / model.diameter);
  const float angle = turn.norm();
  Eigen::Isometry3f step = Eigen::Isometry3f::Identity();
  if (angle > 0.0f) step.linear() = Eigen::AngleAxisf(angle, turn / angle).toRotationMatrix();
  step.translation() = centre + length * motion.tail<3>() - step.linear() * centre;
  return step * T_camera_model;
}

OpenDirections open_directions(const ObservedScene& scene, const RecognitionModel& model,
                               const Eigen::Isometry3f& T_camera_model, float epsilon) {
  constexpr float kWeak = 0.03f;  // of the information of a direction that every point fixes
  OpenDirections open;
  const NormalEquations equations =
      normal_equations(scene, model, T_camera_model, epsilon, model.test_points.size());
  const Eigen::SelfAdjointEigenSolver<Matrix6f> solver(equations.information);
  open.motions = solver.eigenvectors();
  while (open.count < 6 &&
         solver.eigenvalues()[open.count] < kWeak * static_cast<float>(equations.pairs)) {
    ++open.count;
  }
  return open;
}

Eigen::Isometry3f align_projectively(const ObservedScene& scene, const RecognitionModel& model,
                                     const Eigen::Isometry3f& T_camera_model,
                                     const AlignmentOptions& options) {
  constexpr int kLeastPairs = 6;
  constexpr float kSmallMotion = 1e-4f;  // of the diameter
  Eigen::Isometry3f T = T_camera_model;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    NormalEquations equations = normal_equations(scene, model, T, options.epsilon,
                                                 static_cast<std::size_t>(options.points));
    if (equations.pairs < kLeastPairs) break;
    // Directions that the data leave open stay where they are.
    equations.information.diagonal().array() += 0.01f * static_cast<float>(equations.pairs);
    const Vector6f motion = equations.information.ldlt().solve(equations.right);
    if (!motion.allFinite()) break;
    T = move_along(model, T, motion, 1.0f);
    if (motion.norm() < kSmallMotion * model.diameter) break;
  }
  // Rounding in single precision must not accumulate into shear.
  T.linear() = Eigen::Quaternionf(T.linear()).normalized().toRotationMatrix();
  return T;
}

Eigen::Isometry3d refine_pose(const ObservedScene& scene, const RecognitionModel& model,
                              const Eigen::Isometry3d& T_camera_model, double epsilon) {
  constexpr int kPairings = 4;
  constexpr std::size_t kLeastPairs = 12;
  Eigen::Isometry3d T = T_camera_model;
  for (int i = 0; i < kPairings; ++i) {
    std::vector<Correspondence> pairs;
    for_each_correspondence(scene, model, T.cast<float>(), static_cast<float>(3.0 * epsilon),
                            model.test_points.size(),
                            [&](const Correspondence& pair) { pairs.push_back(pair); });
    if (pairs.size() < kLeastPairs) break;
    const Eigen::Vector3d centre = T * model.centre.cast<double>();
    const PointToPlane residuals(std::move(pairs), centre, epsilon);
    ceres::TinySolver<PointToPlane> solver;
    solver.options.max_num_iterations = 8;
    ceres::TinySolver<PointToPlane>::Parameters motion =
        ceres::TinySolver<PointToPlane>::Parameters::Zero();
    solver.Solve(residuals, &motion);
    if (!motion.allFinite()) break;
    T = motion_about(centre, motion.data()) * T;
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    if (motion.norm() < 1e-6) break;
  }
  return T;
}

}  // namespace binpick
