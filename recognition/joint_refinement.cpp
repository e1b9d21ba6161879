#include "recognition/joint_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "recognition/parallel_for.h"
#include "recognition/point_to_plane.h"

namespace binpick {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr int kPairings = 4;
constexpr int kMostPixels = 700;  // of an object: more are too much alike to say more
constexpr std::size_t kLeastPixels = 12;
constexpr double kStepCorrelation = 2.0;  // neighbouring steps that err alike
constexpr float kLeastAcross = 0.6f;      // of a walked direction across the silhouette
constexpr int kFarthestStep = 3;          // pixels from the dilation: others are other objects'

/// The observations of one object at one pose, and what they weigh.
class ObjectEquations {
 public:
  ObjectEquations(const ObservedScene& scene, const SensorEstimate& sensor, double dilation,
                  const RecognitionModel& model, const RefinementOptions& options)
      : scene_(scene),
        sensor_(sensor),
        dilation_(dilation),
        model_(model),
        options_(options),
        gatherer_(scene, sensor) {}

  /// Renders the object; the others' claims come later.
  void render(const Eigen::Isometry3d& T_camera_model) {
    (void)gatherer_.gather(model_, T_camera_model.cast<float>());
    gatherer_.explained_pixels(explained_);
  }
  /// What the object explained when it was rendered.
  [[nodiscard]] const std::vector<int>& explained_pixels() const { return explained_; }

  /// Collects what `claims` leaves the object of what it was rendered on.
  void observe(const Eigen::Isometry3d& T_camera_model, const PixelClaims& claims,
               std::int32_t claimant) {
    const int matched = gatherer_.matched_count(claims, claimant);
    const int stride =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(matched / double{kMostPixels}))));
    gatherer_.matched_pixels(stride, pixels_);
    const auto is_others = [&](int pixel) {
      const std::int32_t owner = claims[static_cast<std::size_t>(pixel)];
      return owner >= 0 && owner != claimant;
    };
    std::erase_if(pixels_, [&](const MatchedPixel& pixel) {
      return is_others(scene_.projection().pixel(pixel.q));
    });
    observations_.clear();
    add_surface(stride, T_camera_model);
    surface_count_ = observations_.size();
    for (const SilhouetteStep& step : gatherer_.silhouette_steps()) {
      // The pixels on the way from where the walk met the object's surface to the step.
      bool is_own = true;
      for (int k = std::min(step.offset, 0); k <= step.offset && is_own; ++k) {
        is_own =
            !is_others((step.v + k * step.dv) * scene_.projection().width + step.u + k * step.du);
      }
      if (is_own) add_step(step);
    }
  }

  /// One robust solve, when the observations can fix a motion.
  void move(Eigen::Isometry3d& T_camera_model) const {
    if (surface_count_ < kLeastPixels) return;
    const PoseStep step =
        fit_point_to_plane(observations_, T_camera_model * model_.centre.cast<double>());
    T_camera_model = step.motion * T_camera_model;
    T_camera_model.linear() =
        Eigen::Quaterniond(T_camera_model.linear()).normalized().toRotationMatrix();
  }

  [[nodiscard]] Matrix6d covariance(const Eigen::Isometry3d& T_camera_model) const {
    const Eigen::Vector3d origin = T_camera_model.translation();
    // The seventh unknown is the error that all steps share; it is known to within its prior.
    Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
    // A model's origin may lie anywhere, that of a segment of a scan at the sensor.
    const Eigen::Vector3d centre = T_camera_model * model_.centre.cast<double>();
    const double pixel = centre.z() / static_cast<double>(scene_.projection().fx);
    information(6, 6) = 1.0 / std::pow(options_.common_step_error * pixel, 2);
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const PlaneObservation& o = observations_[i];
      Eigen::Matrix<double, 7, 1> row;
      row << (o.p - origin).cross(o.normal), o.normal, i < surface_count_ ? 0.0 : 1.0;
      information += o.weight / (o.scale * o.scale) * row * row.transpose();
    }
    // Motions that nothing fixes: no pose is farther off than its model is large.
    const auto diameter = static_cast<double>(model_.diameter);
    information.diagonal().head<3>().array() += 1.0 / (0.25 * 0.25);
    information.diagonal().segment<3>(3).array() += 1.0 / std::pow(0.25 * diameter, 2);
    const Eigen::Matrix<double, 7, 7> all =
        information.ldlt().solve(Eigen::Matrix<double, 7, 7>::Identity());
    Matrix6d covariance = all.topLeftCorner<6, 6>();
    const Eigen::Vector3d sight = centre.normalized();
    covariance.bottomRightCorner<3, 3>() +=
        std::pow(options_.depth_error * centre.norm(), 2) * sight * sight.transpose();
    return 0.5 * (covariance + covariance.transpose());
  }

 private:
  /// A pixel counts by the inverse of what its neighbourhood's errors add up to.
  void add_surface(int stride, const Eigen::Isometry3d& T_camera_model) {
    const double pixel = (T_camera_model * model_.centre.cast<double>()).z() /
                         static_cast<double>(scene_.projection().fx);
    const auto diameter = static_cast<double>(model_.diameter);
    const double patch_pixels = std::max(std::pow(options_.patch * diameter / pixel, 2), 1.0);
    const double shape_variance = std::pow(options_.shape_error * diameter, 2);
    const auto tolerance = static_cast<double>(model_tolerance(model_));
    for (const MatchedPixel& matched : pixels_) {
      const auto noise = static_cast<double>(matched.variance);
      const double alike =
          static_cast<double>(sensor_.correlated_pixels) * noise + patch_pixels * shape_variance;
      const double scale_squared = tolerance * tolerance + noise;
      observations_.push_back({matched.p.cast<double>(), matched.normal.cast<double>(),
                               matched.q.cast<double>(), std::sqrt(scale_squared),
                               stride * stride * scale_squared / alike});
    }
  }

  /// The plane through the sensor and the observed contour.
  void add_step(const SilhouetteStep& step) {
    const Eigen::Vector2f walked(static_cast<float>(step.du), static_cast<float>(step.dv));
    if (!(step.outwards.dot(walked) > kLeastAcross)) return;
    const double moved = step.offset - dilation_;
    if (std::abs(moved) > kFarthestStep) return;
    const Projection& projection = scene_.projection();
    const auto point_at = [&](double along) {
      const double u = step.u + along * step.du;
      const double v = step.v + along * step.dv;
      return Eigen::Vector3d(
          static_cast<double>(step.depth) *
          Eigen::Vector3d(
              (u - static_cast<double>(projection.cx)) / static_cast<double>(projection.fx),
              (v - static_cast<double>(projection.cy)) / static_cast<double>(projection.fy), 1.0));
    };
    PlaneObservation observation;
    observation.p = point_at(0.5);
    observation.q = point_at(0.5 + moved);
    const Eigen::Vector3d m(static_cast<double>(step.outwards.x()),
                            static_cast<double>(step.outwards.y()), 0.0);
    const Eigen::Vector3d sight = observation.p.normalized();
    observation.normal = (m - m.dot(sight) * sight).normalized();
    const double pixel = static_cast<double>(step.depth) / static_cast<double>(projection.fx);
    observation.scale = options_.step_error * pixel;
    observation.weight = 1.0 / kStepCorrelation;
    observations_.push_back(observation);
  }

  const ObservedScene& scene_;
  const SensorEstimate& sensor_;
  double dilation_;
  const RecognitionModel& model_;
  const RefinementOptions& options_;
  EvidenceGatherer gatherer_;
  std::vector<int> explained_;
  std::vector<MatchedPixel> pixels_;
  std::vector<PlaneObservation> observations_;
  std::size_t surface_count_ = 0;
};

/// Gives every pixel to the first of the objects that explain it. `claimed` holds the pixels that
/// are claimed, before and after.
void assign_pixels(const std::vector<ObjectEquations>& objects, PixelClaims& claims,
                   std::vector<int>& claimed) {
  for (const int pixel : claimed) claims[static_cast<std::size_t>(pixel)] = -1;
  claimed.clear();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (const int pixel : objects[i].explained_pixels()) {
      std::int32_t& owner = claims[static_cast<std::size_t>(pixel)];
      if (owner >= 0) continue;
      owner = static_cast<std::int32_t>(i);
      claimed.push_back(pixel);
    }
  }
}

}  // namespace

std::vector<RefinedPose> refine_jointly(std::span<const RecognitionModel> models,
                                        const ObservedScene& scene, const SensorEstimate& sensor,
                                        double dilation, std::span<const Candidate> selected,
                                        int jobs, const RefinementOptions& options) {
  std::vector<RefinedPose> poses(selected.size());
  std::vector<int> all(selected.size());
  std::iota(all.begin(), all.end(), 0);
  refine_moved(models, scene, sensor, dilation, selected, all, poses, jobs, options);
  return poses;
}

void refine_moved(std::span<const RecognitionModel> models, const ObservedScene& scene,
                  const SensorEstimate& sensor, double dilation,
                  std::span<const Candidate> selected, std::span<const int> moved,
                  std::vector<RefinedPose>& poses, int jobs, const RefinementOptions& options) {
  std::vector<ObjectEquations> objects;
  std::vector<int> costs;
  objects.reserve(selected.size());
  for (const Candidate& candidate : selected) {
    const RecognitionModel& model = models[static_cast<std::size_t>(candidate.model)];
    objects.emplace_back(scene, sensor, dilation, model, options);
    costs.push_back(evidence_cost(model, candidate.evidence));
  }
  std::vector<int> costs_of_moved;
  for (const int i : moved) {
    const auto index = static_cast<std::size_t>(i);
    poses[index].T_camera_model = selected[index].T_camera_model.cast<double>();
    costs_of_moved.push_back(costs[index]);
  }
  const auto for_each_moved = [&](const auto& work) {
    parallel_for_longest_first(costs_of_moved, jobs, [&](int k) {
      const int i = moved[static_cast<std::size_t>(k)];
      const auto index = static_cast<std::size_t>(i);
      work(i, objects[index], poses[index]);
    });
  };
  parallel_for_longest_first(costs, jobs, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    objects[index].render(poses[index].T_camera_model);
  });
  PixelClaims claims(scene.pixels().size(), -1);
  std::vector<int> claimed;
  for (int pairing = 0; pairing < kPairings; ++pairing) {
    assign_pixels(objects, claims, claimed);
    for_each_moved([&](int i, ObjectEquations& object, RefinedPose& pose) {
      object.observe(pose.T_camera_model, claims, i);
      object.move(pose.T_camera_model);
      object.render(pose.T_camera_model);
    });
  }
  assign_pixels(objects, claims, claimed);
  for_each_moved([&](int i, ObjectEquations& object, RefinedPose& pose) {
    object.observe(pose.T_camera_model, claims, i);
    pose.covariance = object.covariance(pose.T_camera_model);
  });
}

}  // namespace binpick
