#include "recognition/synthetic_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include "recognition/shapes.h"
#include "recognition/synthetic_camera.h"

namespace binpick::testing {
namespace {

constexpr double kCutAbove = 0.006;     // what is lower goes with the table, m
constexpr double kFloorBelow = 0.75;    // the table, m
constexpr double kLargestLean = 0.7;    // rad
constexpr double kSmallestCopy = 0.85;  // of a near-copy, or
constexpr double kLargestCopy = 1.15;   // times the model's size

Eigen::Isometry3d camera_pose(const SceneParameters& p) {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.translation() << 0.0, -p.height * std::tan(p.tilt), p.height;
  const Eigen::Vector3d forward(0.0, std::sin(p.tilt), -std::cos(p.tilt));
  const Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  T_world_camera.linear() << right, forward.cross(right), forward;
  return Eigen::AngleAxisd(p.bearing, Eigen::Vector3d::UnitZ()) * T_world_camera;
}

/// Upper envelope of what lies on the table, on a 4 mm grid about the world's origin.
class HeightMap {
 public:
  HeightMap() : heights_(kSide * kSide, 0.0f) {}

  /// How far the shape at T can come down (the least gap over its lower envelope).
  [[nodiscard]] float gap_below(const Shape& shape, const Eigen::Isometry3d& T) const {
    float gap = std::numeric_limits<float>::infinity();
    for_each_cell(shape, T,
                  [&](std::size_t cell, float z) { gap = std::min(gap, z - heights_[cell]); });
    return gap;
  }
  void add(const Shape& shape, const Eigen::Isometry3d& T) {
    for_each_cell(shape, T,
                  [&](std::size_t cell, float z) { heights_[cell] = std::max(heights_[cell], z); });
  }

 private:
  static constexpr int kSide = 400;
  static constexpr double kCell = 0.004;

  template <class Visit>
  static void for_each_cell(const Shape& shape, const Eigen::Isometry3d& T, const Visit& visit) {
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
/// are rolled by multiples of 30 degrees so that prisms have a flat side below. Free-form objects
/// lie in any way half of the time.
Eigen::Quaterniond resting_rotation(bool free_form, Random& random) {
  if (free_form && random.index(2) == 0) return random.rotation();
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

struct Body {
  Shape shape;
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  std::int16_t owner = CleanFrame::kForeign;
};

/// Piles bodies up.
class Builder {
 public:
  Builder(const SceneParameters& parameters, Random& random)
      : parameters_(parameters), random_(random), first_place_(random.index(kPlaces.size())) {}

  /// Something that is there before the objects come.
  void put(Shape shape, const Eigen::Isometry3d& T_world_body) {
    heights_.add(shape, T_world_body);
    bodies_.push_back({std::move(shape), T_world_body, CleanFrame::kGround});
  }

  /// In a pile, the lowest of a few places: what would come to lie on top slides off.
  void drop(Shape shape, bool free_form, std::int16_t owner) {
    const bool apart = parameters_.arrangement == Arrangement::kSeparate;
    Eigen::Isometry3d lowest = Eigen::Isometry3d::Identity();
    lowest.translation().z() = std::numeric_limits<double>::infinity();
    for (int i = 0; i < (apart ? 1 : kTries); ++i) {
      const Eigen::Isometry3d T = come_down(shape, apart ? next_place() : somewhere(), free_form);
      if (T.translation().z() < lowest.translation().z()) lowest = T;
    }
    heights_.add(shape, lowest);
    bodies_.push_back({std::move(shape), lowest, owner});
  }
  [[nodiscard]] const std::vector<Body>& bodies() const { return bodies_; }

 private:
  static constexpr std::array<std::array<double, 2>, 6> kPlaces = {
      {{-0.26, -0.1}, {0.0, -0.12}, {0.26, -0.1}, {-0.24, 0.16}, {0.02, 0.14}, {0.26, 0.16}}};

  static constexpr int kTries = 4;

  [[nodiscard]] Eigen::Isometry3d come_down(const Shape& shape, const Eigen::Vector2d& place,
                                            bool free_form) {
    const double lean = parameters_.arrangement == Arrangement::kLeaning ? kLargestLean : 0.0;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << place, 1.0;
    const Eigen::Quaterniond rest = resting_rotation(free_form, random_);
    const Eigen::AngleAxisd tilt(random_.uniform(-lean, lean), random_.unit_vector());
    T.linear() = (Eigen::Quaterniond(tilt) * rest).toRotationMatrix();
    T.translation().z() -= static_cast<double>(heights_.gap_below(shape, T)) - 0.0005;
    return T;
  }
  [[nodiscard]] Eigen::Vector2d next_place() {
    const auto& place = kPlaces[(first_place_ + bodies_.size()) % kPlaces.size()];
    return {place[0], place[1]};
  }
  [[nodiscard]] Eigen::Vector2d somewhere() {
    const double bearing = random_.uniform(0.0, 2.0 * std::numbers::pi);
    const double distance = parameters_.radius * std::sqrt(random_.uniform());
    return {distance * std::cos(bearing), distance * std::sin(bearing)};
  }

  const SceneParameters& parameters_;
  Random& random_;
  std::uint64_t first_place_;
  HeightMap heights_;
  std::vector<Body> bodies_;
};

void put_surroundings(Builder& builder, const SceneParameters& p, Random& random) {
  if (p.surroundings == Surroundings::kBin) {
    const double side = 2.0 * p.radius + random.uniform(0.06, 0.16);
    builder.put(make_walls({side, side * random.uniform(0.8, 1.2)}, random.uniform(0.06, 0.14),
                           random.uniform(0.003, 0.01)),
                Eigen::Isometry3d(Eigen::AngleAxisd(random.uniform(0.0, std::numbers::pi),
                                                    Eigen::Vector3d::UnitZ())));
  }
  if (p.surroundings == Surroundings::kWall) {
    Shape wall = make_board(1.2, 1.0);
    Eigen::Isometry3d T(Eigen::AngleAxisd(p.bearing, Eigen::Vector3d::UnitZ()));
    T.translate(Eigen::Vector3d(0.0, random.uniform(0.28, 0.45), 0.2));
    T.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()));
    builder.put(std::move(wall), T);
  }
  if (p.surroundings == Surroundings::kColumn) {
    const double bearing = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double radius = random.uniform(0.03, 0.12);
    const double height = random.uniform(0.1, 0.5);
    const double distance = p.radius + radius + random.uniform(0.02, 0.2);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << distance * std::cos(bearing), distance * std::sin(bearing), 0.5 * height;
    builder.put(make_shape(make_prism(96, radius, height)), T);
  }
}

/// Which objects come down, in which order: indices of known instances, then the unknown, shuffled.
std::vector<int> drop_order(int count, bool shuffled, Random& random) {
  std::vector<int> order;
  for (int i = 0; i < count; ++i) order.push_back(i);
  for (std::size_t i = order.size(); shuffled && i > 1; --i) {
    std::swap(order[i - 1], order[random.index(i)]);
  }
  return order;
}

void count_visible(SyntheticScene& scene, const std::vector<Coverage>& alone, double baseline) {
  std::vector<int> visible(scene.instances.size(), 0);
  const std::vector<std::uint8_t> shadow = projector_shadow(scene.clean.image, baseline);
  for (std::size_t i = 0; i < shadow.size(); ++i) {
    const std::int16_t owner = scene.clean.owner[i];
    if (owner >= 0 && shadow[i] == 0) ++visible[static_cast<std::size_t>(owner)];
  }
  for (std::size_t i = 0; i < visible.size(); ++i) {
    scene.instances[i].in_frame = alone[i].in_frame;
    scene.instances[i].visible_share =
        static_cast<double>(visible[i]) / std::max(alone[i].pixels, 1);
  }
}

/// Takes what lies on or below the table out of the scan.
void cut_table_away(RangeImage& image) {
  for (int v = 0; v < image.intrinsics.height; ++v) {
    for (int u = 0; u < image.intrinsics.width; ++u) {
      const Eigen::Vector3d p_world = image.T_world_camera * image.p_camera(u, v);
      const auto pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(image.intrinsics.width) +
          static_cast<std::size_t>(u);
      if (p_world.z() < kCutAbove) image.depth[pixel] = 0.0f;
    }
  }
}

PointCloud to_cloud(const RangeImage& image, bool organised,
                    const Eigen::Isometry3d& T_scene_camera) {
  PointCloud cloud;
  for (int v = 0; v < image.intrinsics.height; ++v) {
    for (int u = 0; u < image.intrinsics.width; ++u) {
      const Eigen::Vector3d p = image.p_camera(u, v);
      if (p.z() > 0.0) {
        cloud.points.push_back((T_scene_camera * p).cast<float>());
      } else if (organised) {
        cloud.points.push_back(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
      }
    }
  }
  cloud.width = organised ? image.intrinsics.width : static_cast<int>(cloud.points.size());
  cloud.height = organised ? image.intrinsics.height : 1;
  return cloud;
}

SceneParameters nominal(SceneKind kind) {
  SceneParameters p;
  p.shape_error = 0.0;
  switch (kind) {
    case SceneKind::kSeparate:
      return draw_parameters("separate", 0);
    case SceneKind::kPile:
      return draw_parameters("kinect", 0);
    case SceneKind::kLeaning:
      return draw_parameters("leaning", 0);
    case SceneKind::kLookAlike:
      p.known = p.unknown = 3;
      p.radius = 0.24;
      return p;
    case SceneKind::kForeignOnly:
      return draw_parameters("nothing", 0);
    case SceneKind::kEmptyTable:
      p.known = 0;
  }
  return p;
}

}  // namespace

SceneGenerator::SceneGenerator(std::vector<ModelSource> known) : known_(std::move(known)) {
  for (const ModelSource& source : known_) {
    known_shapes_.push_back(make_shape(std::get<TriangleMesh>(source.shape)));
  }
}

SyntheticScene SceneGenerator::make(SceneKind kind, Seed seed) const {
  return make(nominal(kind), seed);
}

SyntheticScene SceneGenerator::make(const SceneParameters& p, Seed seed) const {
  Random random(derive_seed(seed, "scene"));
  Builder builder(p, random);
  put_surroundings(builder, p, random);
  SyntheticScene scene;
  // Without other objects the known ones come in turn, which spreads the models over the pile.
  const bool mixed = p.unknown + p.copies > 0;
  for (const int i : drop_order(p.known + p.unknown + p.copies, mixed, random)) {
    const Seed shape_seed = derive_seed(derive_seed(seed, "shape"), static_cast<Seed>(i));
    if (i >= p.known + p.copies) {
      builder.drop(make_unknown(known_shapes_, random), false, CleanFrame::kForeign);
      continue;
    }
    const std::size_t model = static_cast<std::size_t>(i) % known_.size();
    const bool free_form = known_[model].symmetries.size() <= 1;
    ShapeError error{1.0 + (random.index(2) == 0 ? -1.0 : 1.0) * p.scale_error, p.shape_error};
    if (i >= p.known) error.scale = random.index(2) == 0 ? kSmallestCopy : kLargestCopy;
    const auto owner = static_cast<std::int16_t>(scene.instances.size());
    builder.drop(distorted(known_shapes_[model], error, shape_seed), free_form,
                 i < p.known ? owner : CleanFrame::kForeign);
    if (i < p.known) {
      scene.instances.push_back({model, builder.bodies().back().T_world_body, 0.0, true});
    }
  }

  SyntheticCamera camera(p.camera, camera_pose(p));
  Eigen::Isometry3d floor = Eigen::Isometry3d::Identity();
  floor.translation().z() = -kFloorBelow;
  camera.draw(make_board(6.0, 6.0), floor, CleanFrame::kGround);
  camera.draw(make_board(p.table_width, p.table_depth), Eigen::Isometry3d::Identity(),
              CleanFrame::kGround);
  std::vector<Coverage> alone(scene.instances.size());
  for (const Body& body : builder.bodies()) {
    const Coverage coverage = camera.draw(body.shape, body.T_world_body, body.owner);
    if (body.owner >= 0) alone[static_cast<std::size_t>(body.owner)] = coverage;
  }
  scene.clean = camera.frame();
  for (TrueInstance& instance : scene.instances) {
    instance.T_camera_model = camera_pose(p).inverse() * instance.T_camera_model;
  }
  count_visible(scene, alone, p.noise.baseline);
  return scene;
}

SyntheticFrame SceneGenerator::frame(const SceneParameters& p, Seed seed) const {
  SyntheticFrame frame;
  frame.parameters = p;
  frame.scene = make(p, seed);
  frame.image = add_sensor_noise(frame.scene.clean, p.noise, derive_seed(seed, "noise"));
  if (p.surroundings == Surroundings::kTableCutAway) cut_table_away(frame.image);
  if (p.form == ScanForm::kRangeImage) return frame;
  Random random(derive_seed(seed, "cloud"));
  const bool organised = p.form == ScanForm::kOrganisedCloud;
  if (!organised) {
    frame.T_scene_camera.linear() = random.rotation().toRotationMatrix();
    frame.T_scene_camera.translation() = random.uniform() * random.unit_vector();
  }
  frame.p_scene_viewpoint =
      frame.T_scene_camera.translation() + p.viewpoint_error * random.unit_vector();
  frame.cloud = to_cloud(frame.image, organised, frame.T_scene_camera);
  return frame;
}

}  // namespace binpick::testing
