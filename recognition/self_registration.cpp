#include "recognition/self_registration.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "recognition/surface_grid.h"

namespace binpick {
namespace {

constexpr float kTolerance = 0.005f;       // of the diameter: 1 mm on 0.2 m
constexpr float kCoarseTolerance = 0.04f;  // before alignment
constexpr float kHoles = 0.032f;           // of the diameter: the surface is no sparser
constexpr float kReach = 0.052f;           // of the diameter: both together
constexpr double kMostTurned = 0.09;       // by alignment, rad
constexpr float kLikeNormal = 0.8f;        // 37 degrees
constexpr double kEqualMoments = 0.06;     // of the largest: only costs time when too wide
constexpr int kHighestOrder = 24;          // of a discrete axis
constexpr int kContinuousSteps = 36;
constexpr std::size_t kLargestGroup = 150;
constexpr int kMostTries = 120;
constexpr double kPi = std::numbers::pi;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Eigen::Isometry3d turn_about(const Eigen::Vector3d& centre, const Eigen::Quaterniond& rotation) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation.toRotationMatrix();
  T.translation() = centre - T.linear() * centre;
  return T;
}

Eigen::Quaterniond turn(const Eigen::Vector3d& axis, double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

/// A surface that can tell how far a turned copy of itself is off.
class Surface {
 public:
  Surface(const std::vector<OrientedPoint>& surface, const std::vector<OrientedPoint>& samples,
          float diameter)
      : grid_(box_of(surface), kReach * diameter), samples_(samples), diameter_(diameter) {
    for (const OrientedPoint& point : surface) grid_.add(point);
    for (const OrientedPoint& point : surface) centre_ += point.p.cast<double>();
    centre_ /= static_cast<double>(surface.size());
    for (const OrientedPoint& point : surface) {
      const Eigen::Vector3d d = point.p.cast<double>() - centre_;
      covariance_ += d * d.transpose() / static_cast<double>(surface.size());
    }
  }

  [[nodiscard]] const Eigen::Vector3d& centre() const { return centre_; }
  [[nodiscard]] const Eigen::Matrix3d& covariance() const { return covariance_; }

  /// Whether every sample, turned, lies within `tolerance` of the surface.
  [[nodiscard]] bool maps_onto_itself(const Eigen::Isometry3d& T, float tolerance) const {
    const Eigen::Matrix3f R = T.linear().cast<float>();
    const Eigen::Vector3f t = T.translation().cast<float>();
    const float reach = std::hypot(tolerance, kHoles * diameter_);
    return std::all_of(samples_.begin(), samples_.end(), [&](const OrientedPoint& sample) {
      const Eigen::Vector3f p = R * sample.p + t;
      const Eigen::Vector3f n = R * sample.n;
      return grid_.any_near(p, [&](const OrientedPoint& other) {
        return std::abs(other.n.dot(p - other.p)) < tolerance && other.n.dot(n) > kLikeNormal &&
               (p - other.p).squaredNorm() < reach * reach;
      });
    });
  }

  /// Whether all samples have the same distance from the centroid.
  [[nodiscard]] bool is_sphere() const {
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0.0;
    for (const OrientedPoint& sample : samples_) {
      const double radius = (sample.p.cast<double>() - centre_).norm();
      nearest = std::min(nearest, radius);
      farthest = std::max(farthest, radius);
    }
    return farthest - nearest < 3.0 * static_cast<double>(kTolerance * diameter_);
  }

  /// Point-to-plane alignment of the turned surface with the surface.
  [[nodiscard]] Eigen::Isometry3d align(Eigen::Isometry3d T) const {
    constexpr int kIterations = 6;
    constexpr std::size_t kAlignedSamples = 192;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Matrix6d information = 1e-3 * Matrix6d::Identity();
      Vector6d right = Vector6d::Zero();
      for (std::size_t i = 0; i < std::min(kAlignedSamples, samples_.size()); ++i) {
        add_equation(T, samples_[i], information, right);
      }
      const Vector6d motion = information.ldlt().solve(right);
      const Eigen::Vector3d turn = motion.head<3>() / (0.5 * static_cast<double>(diameter_));
      const double angle = turn.norm();
      if (!motion.allFinite() || angle > 0.3) break;
      if (angle > 0.0) {
        const Eigen::Quaterniond step(Eigen::AngleAxisd(angle, turn / angle));
        T = turn_about(centre_, step) * T;
      }
      T.pretranslate(motion.tail<3>());
      if (motion.norm() < 1e-5 * static_cast<double>(diameter_)) break;
    }
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    return T;
  }

 private:
  static Eigen::AlignedBox3f box_of(const std::vector<OrientedPoint>& points) {
    Eigen::AlignedBox3f box;
    for (const OrientedPoint& point : points) box.extend(point.p);
    return box;
  }

  void add_equation(const Eigen::Isometry3d& T, const OrientedPoint& sample, Matrix6d& information,
                    Vector6d& right) const {
    const Eigen::Vector3d p = T * sample.p.cast<double>();
    const Eigen::Vector3f n = (T.linear() * sample.n.cast<double>()).cast<float>();
    const Eigen::Vector3f at = p.cast<float>();
    const OrientedPoint* nearest = nullptr;
    float least = std::pow(kReach * diameter_, 2.0f);
    grid_.any_near(at, [&](const OrientedPoint& other) {
      const float squared = (other.p - at).squaredNorm();
      if (squared < least && other.n.dot(n) > kLikeNormal) {
        least = squared;
        nearest = &other;
      }
      return false;
    });
    if (nearest == nullptr) return;
    const Eigen::Vector3d m = nearest->n.cast<double>();
    const Eigen::Vector3d arm = (p - centre_) / (0.5 * static_cast<double>(diameter_));
    Vector6d row;
    row << arm.cross(m), m;
    information += row * row.transpose();
    right += row * m.dot(nearest->p.cast<double>() - p);
  }

  SurfaceGrid grid_;
  const std::vector<OrientedPoint>& samples_;
  float diameter_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
};

/// The symmetry near `T`, if there is one.
std::optional<Eigen::Isometry3d> align_to_symmetry(const Surface& surface,
                                                   const Eigen::Isometry3d& T, float diameter) {
  if (!surface.maps_onto_itself(T, kCoarseTolerance * diameter)) return std::nullopt;
  const Eigen::Isometry3d aligned = surface.align(T);
  const Eigen::AngleAxisd turned(aligned.linear() * T.linear().transpose());
  if (turned.angle() > kMostTurned || !surface.maps_onto_itself(aligned, kTolerance * diameter)) {
    return std::nullopt;
  }
  return aligned;
}

/// The group that is found, closed under composition.
class SymmetryGroup {
 public:
  SymmetryGroup(const Surface& surface, float diameter) : surface_(surface), diameter_(diameter) {}

  [[nodiscard]] const std::vector<Eigen::Isometry3d>& elements() const { return elements_; }

  /// Adds the rotation if it is a symmetry and is not known; says whether it is one. Tries no more
  /// than a limited number: what resembles a sphere resembles itself turned by anything.
  bool try_rotation(const Eigen::Quaterniond& rotation) {
    const Eigen::Isometry3d T = turn_about(surface_.centre(), rotation);
    if (knows(T)) return true;
    if (tries_ == kMostTries || !surface_.maps_onto_itself(T, kCoarseTolerance * diameter_)) {
      return false;
    }
    ++tries_;
    const auto aligned = align_to_symmetry(surface_, T, diameter_);
    if (!aligned) return false;
    if (!knows(*aligned)) extend_by(*aligned);
    return true;
  }

  void set(std::vector<Eigen::Isometry3d> elements) { elements_ = std::move(elements); }

  /// Adds `T` and all that follows from it.
  void extend_by(const Eigen::Isometry3d& T) {
    elements_.push_back(T);
    for (std::size_t i = 1; i < elements_.size(); ++i) {
      for (std::size_t j = 1; j < elements_.size() && elements_.size() < kLargestGroup; ++j) {
        Eigen::Isometry3d product = elements_[i] * elements_[j];
        product.linear() = Eigen::Quaterniond(product.linear()).normalized().toRotationMatrix();
        if (!knows(product)) elements_.push_back(product);
      }
    }
    if (elements_.size() < kLargestGroup) return;
    // Near-symmetries of something round that close to no group.
    elements_.resize(1);
    tries_ = kMostTries;
  }

 private:
  [[nodiscard]] bool knows(const Eigen::Isometry3d& T) const {
    constexpr double kSameAngle = 0.07;  // 4 degrees, a quarter of a 24-fold axis' step
    return std::any_of(elements_.begin(), elements_.end(), [&](const Eigen::Isometry3d& known) {
      return Eigen::Quaterniond(known.linear()).angularDistance(Eigen::Quaterniond(T.linear())) <
             kSameAngle;
    });
  }

  const Surface& surface_;
  float diameter_;
  int tries_ = 0;
  std::vector<Eigen::Isometry3d> elements_ = {Eigen::Isometry3d::Identity()};
};

/// A rotation about some axis, close to a wanted one, that is as good by any angle.
struct ContinuousAxis {
  Eigen::Vector3d direction;
  Eigen::Vector3d centre;
};

/// Whether turns that no discrete axis of order up to 24 shares are symmetries.
std::optional<ContinuousAxis> continuous_axis(const Surface& surface, float diameter,
                                              const Eigen::Vector3d& direction) {
  constexpr std::array<double, 4> kAngles = {0.13, 0.41, 1.0, 2.3};
  constexpr double kSameAngle = 0.06;  // a facet of a finely tessellated body turns it a little
  std::optional<ContinuousAxis> axis;
  for (const double angle : kAngles) {
    const auto T =
        align_to_symmetry(surface, turn_about(surface.centre(), turn(direction, angle)), diameter);
    if (!T) return std::nullopt;
    const Eigen::AngleAxisd turned(T->linear());
    if (std::abs(turned.angle() - angle) > kSameAngle) return std::nullopt;
    // The fixed point of T that is level with the centroid.
    const Eigen::Vector3d& a = turned.axis();
    const Eigen::Matrix3d fixed = Eigen::Matrix3d::Identity() - T->linear() + a * a.transpose();
    axis = {a, fixed.partialPivLu().solve(T->translation() + a * a.dot(surface.centre()))};
  }
  return axis;
}

/// Rotational symmetries about `direction`, of the highest order there is.
void find_about_axis(SymmetryGroup& group, const Surface& surface, float diameter,
                     const Eigen::Vector3d& direction) {
  if (const auto axis = continuous_axis(surface, diameter, direction)) {
    std::vector<Eigen::Isometry3d> steps;
    for (int i = 0; i < kContinuousSteps; ++i) {
      steps.push_back(
          turn_about(axis->centre, turn(axis->direction, 2.0 * kPi * i / kContinuousSteps)));
    }
    group.set(std::move(steps));
    return;
  }
  for (int order = kHighestOrder; order >= 2; --order) {
    if (group.try_rotation(turn(direction, 2.0 * kPi / order))) return;
  }
}

/// Half turns about axes perpendicular to `axis`: one is enough, the others follow.
void find_across_axis(SymmetryGroup& group, const Eigen::Vector3d& axis) {
  constexpr int kSteps = 60;  // of 3 degrees
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  for (int i = 0; i < kSteps; ++i) {
    const double angle = kPi * i / kSteps;
    if (group.try_rotation(turn(std::cos(angle) * u + std::sin(angle) * v, kPi))) return;
  }
}

/// The directions of half a sphere, evenly spread (Fibonacci lattice).
std::vector<Eigen::Vector3d> half_sphere() {
  constexpr int kDirections = 2500;  // some 3 degrees apart
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < kDirections; ++i) {
    const double z = (i + 0.5) / kDirections;
    const double r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(kGoldenAngle * i), r * std::sin(kGoldenAngle * i), z);
  }
  return directions;
}

std::vector<Eigen::Isometry3d> icosahedral_group(const Eigen::Vector3d& centre) {
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  const Eigen::Quaterniond fifth =
      turn(Eigen::Vector3d(0.0, 1.0, golden).normalized(), 2.0 * kPi / 5.0);
  const Eigen::Quaterniond third = turn(Eigen::Vector3d::Ones().normalized(), 2.0 * kPi / 3.0);
  std::vector<Eigen::Quaterniond> all = {Eigen::Quaterniond::Identity()};
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Eigen::Quaterniond& generator : {fifth, third}) {
      const Eigen::Quaterniond next = (all[i] * generator).normalized();
      const bool known = std::any_of(all.begin(), all.end(), [&](const auto& other) {
        return other.angularDistance(next) < 0.1;
      });
      if (!known) all.push_back(next);
    }
  }
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Quaterniond& rotation : all) poses.push_back(turn_about(centre, rotation));
  return poses;
}

/// A body with three equal moments: a sphere, a cube, another Platonic body, or chance.
void find_about_any_axis(SymmetryGroup& group, const Surface& surface) {
  if (surface.is_sphere()) {
    group.set(icosahedral_group(surface.centre()));
    return;
  }
  for (const Eigen::Vector3d& axis : half_sphere()) {
    for (const int order : {2, 3, 4, 5}) group.try_rotation(turn(axis, 2.0 * kPi / order));
  }
}

}  // namespace

std::vector<Eigen::Isometry3d> find_symmetries(const std::vector<OrientedPoint>& surface,
                                               const std::vector<OrientedPoint>& samples,
                                               float diameter) {
  const Surface body(surface, samples, diameter);
  SymmetryGroup group(body, diameter);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(body.covariance());
  const Eigen::Vector3d& moments = solver.eigenvalues();
  const Eigen::Matrix3d& axes = solver.eigenvectors();
  const bool low_equal = moments[1] - moments[0] < kEqualMoments * moments[2];
  const bool high_equal = moments[2] - moments[1] < kEqualMoments * moments[2];
  if (low_equal && high_equal) {
    find_about_any_axis(group, body);
  } else if (low_equal || high_equal) {
    const Eigen::Vector3d axis = axes.col(low_equal ? 2 : 0);
    find_about_axis(group, body, diameter, axis);
    find_across_axis(group, axis);
  } else {
    for (int i = 0; i < 3; ++i) group.try_rotation(turn(axes.col(i), kPi));
  }
  return group.elements();
}

}  // namespace binpick
