#include "recognition/evaluation_picture.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <variant>
#include <vector>

#include "models/errors.h"
#include "recognition/synthetic_camera.h"

namespace binpick::testing {
namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kGreen = {40, 220, 60};
constexpr Colour kRed = {255, 40, 40};
constexpr Colour kOrange = {255, 160, 0};
constexpr Colour kMagenta = {255, 0, 255};
constexpr Colour kWhite = {255, 255, 255};

class Picture {
 public:
  explicit Picture(const RangeImage& image)
      : camera_(image.intrinsics),
        pixels_(3 * static_cast<std::size_t>(camera_.width) *
                static_cast<std::size_t>(camera_.height)) {
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const auto grey = static_cast<std::uint8_t>(brightness(image, u, v));
        set(u, v, {grey, grey, static_cast<std::uint8_t>(grey / 2 + (grey > 0 ? 60 : 0))});
      }
    }
  }

  void outline(const TriangleMesh& mesh, const Eigen::Isometry3d& T_camera_model,
               const Colour& colour) {
    Shape shape;
    for (const Eigen::Vector3d& p : mesh.vertices) shape.vertices.push_back(p.cast<float>());
    shape.triangles = mesh.triangles;
    SyntheticCamera camera(camera_, Eigen::Isometry3d::Identity());
    camera.draw(shape, T_camera_model, 0);
    const RangeImage& drawn = camera.frame().image;
    for (int v = 1; v + 1 < camera_.height; ++v) {
      for (int u = 1; u + 1 < camera_.width; ++u) {
        const bool inside = drawn.at(u, v) > 0.0f;
        if (inside != (drawn.at(u + 1, v) > 0.0f) || inside != (drawn.at(u, v + 1) > 0.0f)) {
          set(u, v, colour);
        }
      }
    }
  }

  void write(const std::filesystem::path& file) const {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(camera_.width);
    image.height = static_cast<png_uint_32>(camera_.height);
    image.format = PNG_FORMAT_RGB;
    if (png_image_write_to_file(&image, file.c_str(), 0, pixels_.data(), 0, nullptr) == 0) {
      throw IoError(file.string() + ": " + image.message);
    }
  }

 private:
  /// Of a surface lit from the camera; 0 where nothing was measured.
  static double brightness(const RangeImage& image, int u, int v) {
    constexpr int kStep = 2;
    const CameraIntrinsics& camera = image.intrinsics;
    const auto point = [&](int pu, int pv) {
      return image.p_camera(std::clamp(pu, 0, camera.width - 1),
                            std::clamp(pv, 0, camera.height - 1));
    };
    const Eigen::Vector3d p = point(u, v);
    if (!(p.z() > 0.0)) return 0.0;
    const Eigen::Vector3d right = point(u + kStep, v) - point(u - kStep, v);
    const Eigen::Vector3d down = point(u, v + kStep) - point(u, v - kStep);
    const double cosine = std::abs(right.cross(down).normalized().dot(p.normalized()));
    return 40.0 + 190.0 * cosine * cosine;
  }
  void set(int u, int v, const Colour& colour) {
    const auto i = 3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width) +
                        static_cast<std::size_t>(u));
    std::copy(colour.begin(), colour.end(), pixels_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  CameraIntrinsics camera_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace

void write_picture(const std::filesystem::path& file, const SyntheticFrame& frame,
                   std::span<const Detection> detections, const FrameScore& score,
                   std::span<const ModelSource> models) {
  Picture picture(frame.image);
  const Eigen::Isometry3d T_camera_scene = frame.T_scene_camera.inverse();
  const auto mesh_of = [&](const std::string& name) -> const TriangleMesh& {
    const auto source = std::find_if(models.begin(), models.end(),
                                     [&](const ModelSource& m) { return m.name == name; });
    return std::get<TriangleMesh>(source->shape);
  };
  const auto draw = [&](std::size_t detection, const Colour& colour) {
    picture.outline(mesh_of(detections[detection].model),
                    T_camera_scene * detections[detection].T_scene_model, colour);
  };
  for (const FrameScore::Match& match : score.matches) draw(match.detection, kWhite);
  for (std::size_t i = 0; i < score.found.size(); ++i) {
    const TrueInstance& instance = frame.scene.instances[i];
    const bool counts = instance.in_frame && instance.visible_share >= 0.3;
    picture.outline(std::get<TriangleMesh>(models[instance.model].shape), instance.T_camera_model,
                    score.found[i] ? kGreen
                    : counts       ? kRed
                                   : kOrange);
  }
  for (const std::size_t detection : score.false_detections) draw(detection, kMagenta);
  picture.write(file);
}

}  // namespace binpick::testing
