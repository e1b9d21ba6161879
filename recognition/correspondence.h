#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// A model point and the scene point seen in its pixel, camera frame.
struct Correspondence {
  Eigen::Vector3f p_camera;  // of the model
  Eigen::Vector3f normal;    // of the model
  Eigen::Vector3f q_camera;  // of the scene
};

/// Projective data association: calls `visit` for each of the first `count` model points that face
/// the sensor and see a scene point within `epsilon` with a similar normal.
template <class Visit>
void for_each_correspondence(const ObservedScene& scene, const RecognitionModel& model,
                             const Eigen::Isometry3f& T_camera_model, float epsilon,
                             std::size_t count, const Visit& visit) {
  constexpr float kLikeNormal = 0.7f;
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

}  // namespace binpick
