#include "recognition/synthetic_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "recognition/depth_rasterizer.h"
#include "recognition/shapes.h"

namespace binpick::testing {
namespace {

constexpr double kCameraHeight = 0.774;
constexpr double kCameraTilt = 33.6 * std::numbers::pi / 180.0;

CameraIntrinsics kinect() { return {640, 480, 580.0, 580.0, 319.5, 239.5}; }

Eigen::Isometry3d camera_pose() {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.translation() << 0.0, -kCameraHeight * std::tan(kCameraTilt), kCameraHeight;
  const Eigen::Vector3d forward(0.0, std::sin(kCameraTilt), -std::cos(kCameraTilt));
  const Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  T_world_camera.linear() << right, forward.cross(right), forward;
  return T_world_camera;
}

struct Body {
  const RecognitionModel* shape;
  Eigen::Isometry3d T_world_body;
  int instance;  // -1 for what is no known object
};

/// Upper envelope of what lies on the table, on a 4 mm grid about the world's origin.
class HeightMap {
 public:
  HeightMap() : heights_(kSide * kSide, 0.0f) {}

  /// How far `shape` at T can come down (the least gap over its lower envelope).
  [[nodiscard]] float gap_below(const RecognitionModel& shape, const Eigen::Isometry3d& T) const {
    float gap = std::numeric_limits<float>::infinity();
    for_each_cell(shape, T,
                  [&](std::size_t cell, float z) { gap = std::min(gap, z - heights_[cell]); });
    return gap;
  }
  void add(const RecognitionModel& shape, const Eigen::Isometry3d& T) {
    for_each_cell(shape, T,
                  [&](std::size_t cell, float z) { heights_[cell] = std::max(heights_[cell], z); });
  }

 private:
  static constexpr int kSide = 400;
  static constexpr double kCell = 0.004;

  template <class Visit>
  static void for_each_cell(const RecognitionModel& shape, const Eigen::Isometry3d& T,
                            const Visit& visit) {
    for (const Eigen::Vector3f& p_body : shape.cover) {
      const Eigen::Vector3d p = T * p_body.cast<double>();
      const int x = static_cast<int>(p.x() / kCell + 0.5 * kSide);
      const int y = static_cast<int>(p.y() / kCell + 0.5 * kSide);
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, kSide - 1); ++j) {
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, kSide - 1); ++i) {
          visit(static_cast<std::size_t>(j * kSide + i), static_cast<float>(p.z()));
        }
      }
    }
  }
  std::vector<float> heights_;
};

/// A pose in which the object could stand or lie: one of its axes vertical, any yaw; lying bodies
/// are rolled by multiples of 60 or 90 degrees so that a flat side is below.
Eigen::Quaterniond resting_rotation(Random& random) {
  const std::uint64_t kind = random.index(4);
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  const Eigen::AngleAxisd roll(std::numbers::pi / 6.0 * static_cast<double>(random.index(12)),
                               Eigen::Vector3d::UnitZ());
  if (kind == 1) rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  if (kind >= 2) {
    rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()) * roll;
  }
  const Eigen::AngleAxisd yaw(random.uniform(0.0, 2.0 * std::numbers::pi),
                              Eigen::Vector3d::UnitZ());
  return yaw * rotation;
}

class Builder {
 public:
  explicit Builder(Seed seed) : random_(seed) {}

  Random& random() { return random_; }

  /// Lets `shape` down somewhere within `radius` of the middle.
  void drop(const RecognitionModel& shape, double radius, double tilt, int instance) {
    const double bearing = random_.uniform(0.0, 2.0 * std::numbers::pi);
    const double distance = radius * std::sqrt(random_.uniform());
    drop_at(shape, {distance * std::cos(bearing), distance * std::sin(bearing)}, tilt, instance);
  }
  void drop_at(const RecognitionModel& shape, const Eigen::Vector2d& xy, double tilt,
               int instance) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const Eigen::Quaterniond rest = resting_rotation(random_);
    const Eigen::AngleAxisd lean(random_.uniform(-tilt, tilt), random_.unit_vector());
    T.linear() = (Eigen::Quaterniond(lean) * rest).toRotationMatrix();
    T.translation() << xy, 1.0;
    T.translation().z() -= heights_.gap_below(shape, T) - 0.0005f;
    heights_.add(shape, T);
    bodies_.push_back({&shape, T, instance});
  }
  [[nodiscard]] const std::vector<Body>& bodies() const { return bodies_; }

 private:
  Random random_;
  HeightMap heights_;
  std::vector<Body> bodies_;
};

/// Well apart: places on a grid of 0.24 m.
void place_apart(Builder& builder, const std::vector<const RecognitionModel*>& shapes,
                 const std::vector<int>& instances) {
  constexpr std::array<std::array<double, 2>, 6> kPlaces = {
      {{-0.26, -0.1}, {0.0, -0.12}, {0.26, -0.1}, {-0.24, 0.16}, {0.02, 0.14}, {0.26, 0.16}}};
  const std::uint64_t first = builder.random().index(kPlaces.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto& place = kPlaces[(first + i) % kPlaces.size()];
    builder.drop_at(*shapes[i], {place[0], place[1]}, 0.0, instances[i]);
  }
}

class Camera {
 public:
  Camera() {
    const CameraIntrinsics camera = kinect();
    frame_.image.intrinsics = camera;
    frame_.image.T_world_camera = camera_pose();
    const auto size =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    frame_.image.depth.assign(size, 0.0f);
    frame_.cosine.assign(size, 0.0f);
    owner_.assign(size, -1);
    projection_ = {camera.width,     camera.height,    float(camera.fx),
                   float(camera.fy), float(camera.cx), float(camera.cy)};
  }

  /// Draws a body; returns how many pixels it covers alone and whether it stays inside the image.
  std::pair<int, bool> draw(const RecognitionModel& shape, const Eigen::Isometry3d& T_world_body,
                            int owner) {
    const Eigen::Isometry3f T =
        (frame_.image.T_world_camera.inverse() * T_world_body).cast<float>();
    const RenderedModel& rendered = rasterizer_.render(shape.render_mesh, T, projection_);
    int alone = 0;
    for (int v = 0; v < rendered.height; ++v) {
      for (int u = 0; u < rendered.width; ++u) {
        if (!rendered.covers(u, v)) continue;
        ++alone;
        const auto pixel =
            static_cast<std::size_t>((rendered.v0 + v) * projection_.width + rendered.u0 + u);
        const float z = rendered.depth[rendered.index(u, v)];
        float& nearest = frame_.image.depth[pixel];
        if (nearest > 0.0f && nearest <= z) continue;
        nearest = z;
        owner_[pixel] = owner;
        const auto triangle = static_cast<std::size_t>(rendered.triangle[rendered.index(u, v)]);
        const Eigen::Vector3f n = T.linear() * shape.render_mesh.normals[triangle];
        const Eigen::Vector3f ray =
            projection_.point(rendered.u0 + u, rendered.v0 + v, 1.0f).normalized();
        frame_.cosine[pixel] = -n.dot(ray);
      }
    }
    const bool inside = rendered.u0 > 0 && rendered.v0 > 0 &&
                        rendered.u0 + rendered.width < projection_.width &&
                        rendered.v0 + rendered.height < projection_.height;
    return {alone, inside};
  }
  [[nodiscard]] int visible(int owner) const {
    return static_cast<int>(std::count(owner_.begin(), owner_.end(), owner));
  }
  [[nodiscard]] const CleanFrame& frame() const { return frame_; }

 private:
  CleanFrame frame_;
  std::vector<int> owner_;
  Projection projection_;
  DepthRasterizer rasterizer_;
};

/// A finely divided rectangle, so that no triangle reaches behind the camera.
TriangleMesh make_board(double width, double depth) {
  TriangleMesh mesh;
  constexpr std::int32_t kCells = 12;
  for (std::int32_t j = 0; j <= kCells; ++j) {
    for (std::int32_t i = 0; i <= kCells; ++i) {
      mesh.vertices.emplace_back(width * (i / double{kCells} - 0.5),
                                 depth * (j / double{kCells} - 0.5), 0.0);
      if (i == kCells || j == kCells) continue;
      const std::int32_t a = j * (kCells + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + kCells + 2});
      mesh.triangles.push_back({a, a + kCells + 2, a + kCells + 1});
    }
  }
  return mesh;
}

RecognitionModel make_ground(const char* name, double width, double depth) {
  return make_recognition_model(name, make_board(width, depth), {});
}

}  // namespace

SceneGenerator::SceneGenerator(std::vector<ModelSource> known) : known_(std::move(known)) {
  for (const ModelSource& source : known_) {
    known_shapes_.push_back(make_recognition_model(
        source.name, std::get<TriangleMesh>(source.shape), source.symmetries));
  }
  const std::vector<TriangleMesh> foreign = {
      make_box({0.20, 0.13, 0.06}), make_box({0.12, 0.10, 0.10}), make_box({0.16, 0.16, 0.05}),
      make_prism(8, 0.05, 0.16),    make_prism(40, 0.04, 0.20),   make_sphere(0.06)};
  for (const TriangleMesh& mesh : foreign) {
    foreign_shapes_.push_back(make_recognition_model("foreign", mesh, {}));
  }
}

SyntheticScene SceneGenerator::make(SceneKind kind, Seed seed) const {
  Builder builder(derive_seed(seed, "scene"));
  std::vector<std::size_t> models;
  const auto add_known = [&](double radius, double tilt) {
    const std::size_t model = models.size() % known_shapes_.size();
    builder.drop(known_shapes_[model], radius, tilt, static_cast<int>(models.size()));
    models.push_back(model);
  };
  const auto pick_foreign = [&]() -> const RecognitionModel& {
    return foreign_shapes_[builder.random().index(foreign_shapes_.size())];
  };
  if (kind == SceneKind::kSeparate) {
    std::vector<const RecognitionModel*> shapes;
    for (std::size_t i = 0; i < 3; ++i) {
      models.push_back(i % known_shapes_.size());
      shapes.push_back(&known_shapes_[models.back()]);
    }
    place_apart(builder, shapes, {0, 1, 2});
  }
  if (kind == SceneKind::kPile) {
    for (int i = 0; i < 7; ++i) add_known(0.16, 0.0);
  }
  if (kind == SceneKind::kLeaning) {
    for (int i = 0; i < 5; ++i) add_known(0.18, 0.7);
  }
  if (kind == SceneKind::kLookAlike) {
    for (int i = 0; i < 3; ++i) {
      add_known(0.22, 0.0);
      builder.drop(pick_foreign(), 0.25, 0.2, -1);
    }
  }
  if (kind == SceneKind::kForeignOnly) {
    for (int i = 0; i < 5; ++i) builder.drop(pick_foreign(), 0.22, 0.2, -1);
  }

  static const RecognitionModel table = make_ground("table", 1.3, 0.9);
  static const RecognitionModel floor = make_ground("floor", 6.0, 6.0);
  Camera camera;
  Eigen::Isometry3d below = Eigen::Isometry3d::Identity();
  camera.draw(table, below, -1);
  below.translation().z() = -0.75;
  camera.draw(floor, below, -1);
  SyntheticScene scene;
  scene.instances.resize(models.size());
  std::vector<int> alone(models.size(), 0);
  for (const Body& body : builder.bodies()) {
    const auto [pixels, inside] = camera.draw(*body.shape, body.T_world_body, body.instance);
    if (body.instance < 0) continue;
    const auto i = static_cast<std::size_t>(body.instance);
    alone[i] = pixels;
    scene.instances[i] = {models[i], camera_pose().inverse() * body.T_world_body, 0.0, inside};
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    scene.instances[i].visible_share =
        static_cast<double>(camera.visible(static_cast<int>(i))) / std::max(alone[i], 1);
  }
  scene.clean = camera.frame();
  return scene;
}

}  // namespace binpick::testing
