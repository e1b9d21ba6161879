#include "experiments/replay_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "experiments/base64.h"

namespace binpick {
namespace {

using nlohmann::json;

constexpr std::size_t kMostVertices = 65536;  // that 16 bits can number

// Micrometres are plenty to look at.
double short_number(double value) { return std::round(1e6 * value) / 1e6; }

json list(const mjtNum* values, int count) {
  json numbers = json::array();
  for (int i = 0; i < count; ++i) numbers.push_back(short_number(values[i]));
  return numbers;
}

json list(const Eigen::Vector3d& v) { return list(v.data(), 3); }

/// MuJoCo's quaternions begin with w, those of three.js end with it.
json pose(const mjtNum* position, const mjtNum* quaternion) {
  json numbers = list(position, 3);
  for (const int i : {1, 2, 3, 0}) numbers.push_back(short_number(quaternion[i]));
  return numbers;
}

const char* kind_name(int type) {
  switch (type) {
    case mjGEOM_PLANE:
      return "plane";
    case mjGEOM_SPHERE:
      return "sphere";
    case mjGEOM_CAPSULE:
      return "capsule";
    case mjGEOM_CYLINDER:
      return "cylinder";
    case mjGEOM_BOX:
      return "box";
    default:
      return "mesh";
  }
}

class SceneWriter {
 public:
  explicit SceneWriter(const World& world) : world_(world), model_(world.model()) {}

  json write() {
    const std::vector<int> moving = moving_bodies(model_);
    json scene{{"shapes", json::array()}, {"bodies", json::array()}, {"parts", json::array()}};
    for (const int body : moving) scene["bodies"].push_back(mj_id2name(&model_, mjOBJ_BODY, body));
    for (int geom = 0; geom < model_.ngeom; ++geom) {
      // Group 2 is what everybody sees, 4 what pictures show besides (mjcf_writer.h).
      if (model_.geom_group[geom] != 2 && model_.geom_group[geom] != 4) continue;
      const auto body = std::find(moving.begin(), moving.end(), model_.geom_bodyid[geom]);
      scene["parts"].push_back(part(geom, body == moving.end() ? -1 : int(body - moving.begin())));
    }
    scene["shapes"] = std::move(shapes_);
    const Scene& description = world_.shared().parts.scene;
    scene["camera"] = {{"position", list(description.picture_position)},
                       {"look_at", list(description.picture_look_at)}};
    return scene;
  }

 private:
  json part(int geom, int body) {
    json part{{"body", body}, {"colour", colour(geom)}};
    if (body >= 0) {
      part["pose"] = pose(model_.geom_pos + 3 * geom, model_.geom_quat + 4 * geom);
    } else {
      std::array<mjtNum, 4> quaternion{};
      mju_mat2Quat(quaternion.data(), world_.data().geom_xmat + 9 * geom);
      part["pose"] = pose(world_.data().geom_xpos + 3 * geom, quaternion.data());
    }
    part["kind"] = kind_name(model_.geom_type[geom]);
    if (model_.geom_type[geom] == mjGEOM_MESH) {
      part["shape"] = shape(model_.geom_dataid[geom]);
    } else {
      part["size"] = list(model_.geom_size + 3 * geom, 3);
    }
    return part;
  }

  [[nodiscard]] json colour(int geom) const {
    const int material = model_.geom_matid[geom];
    const float* rgba = material < 0 ? model_.geom_rgba + 4 * geom : model_.mat_rgba + 4 * material;
    std::array<double, 4> values{};
    std::copy_n(rgba, 4, values.begin());
    const int texture = material < 0 ? -1 : model_.mat_texid[material];
    if (texture >= 0) tint(texture, values);
    json numbers = json::array();
    for (const double value : values) numbers.push_back(std::round(1e3 * value) / 1e3);
    return numbers;
  }

  // A texture's mean colour stands for it.
  void tint(int texture, std::array<double, 4>& colour) const {
    const int pixels = model_.tex_width[texture] * model_.tex_height[texture];
    const mjtByte* rgb = model_.tex_rgb + model_.tex_adr[texture];
    std::array<double, 3> sum{};
    for (int i = 0; i < 3 * pixels; ++i) sum[std::size_t(i % 3)] += rgb[i];
    for (std::size_t i = 0; i < 3; ++i) colour[i] *= sum[i] / (255.0 * pixels);
  }

  // The place of a mesh among the shapes.
  std::size_t shape(int mesh) {
    const auto [found, fresh] = shape_of_mesh_.emplace(mesh, shapes_.size());
    if (fresh) shapes_.push_back(quantized(mesh));
    return found->second;
  }

  [[nodiscard]] json quantized(int mesh) const {
    const auto count = static_cast<std::size_t>(model_.mesh_vertnum[mesh]);
    const float* vertices = model_.mesh_vert + 3 * model_.mesh_vertadr[mesh];
    std::array<double, 3> lowest{};
    std::array<double, 3> step{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = std::numeric_limits<double>::infinity();
      double high = -low;
      for (std::size_t i = axis; i < 3 * count; i += 3) {
        low = std::min(low, double{vertices[i]});
        high = std::max(high, double{vertices[i]});
      }
      lowest[axis] = low;
      step[axis] = std::max(high - low, 1e-9) / 65535.0;
    }
    std::vector<std::uint16_t> multiples(3 * count);
    for (std::size_t i = 0; i < multiples.size(); ++i) {
      const double multiple = (double{vertices[i]} - lowest[i % 3]) / step[i % 3];
      multiples[i] = static_cast<std::uint16_t>(std::clamp(std::lround(multiple), 0L, 65535L));
    }
    const int* face = model_.mesh_face + 3 * model_.mesh_faceadr[mesh];
    const std::vector<std::uint32_t> triangles(face, face + 3 * model_.mesh_facenum[mesh]);
    return {{"lowest", lowest},
            {"step", step},
            {"vertices", base64_of(multiples)},
            {"triangles", count > kMostVertices ? base64_of(triangles)
                                                : base64_of(std::vector<std::uint16_t>(
                                                      triangles.begin(), triangles.end()))}};
  }

  const World& world_;
  const mjModel& model_;
  json shapes_ = json::array();
  std::map<int, std::size_t> shape_of_mesh_;
};

}  // namespace

std::vector<int> moving_bodies(const mjModel& model) {
  std::vector<int> bodies;
  for (int body = 1; body < model.nbody; ++body) {
    if (model.body_weldid[body] != 0 || model.body_mocapid[body] >= 0) bodies.push_back(body);
  }
  return bodies;
}

json replay_scene(const World& world) { return SceneWriter(world).write(); }

}  // namespace binpick
