// Writes a scan of one object as a camera in the origin would see it:  make_scene MODEL SCENE.ply
#include <Eigen/Geometry>

#include "models/cloud_file.h"
#include "models/mesh_geometry.h"
#include "models/mesh_import.h"
#include "models/range_image.h"

int main(int, char** argv) {
  const binpick::TriangleMesh mesh = binpick::import_mesh(argv[1]);
  // Turned so that three of its sides show, and put down 0.8 m in front of the camera.
  Eigen::Isometry3d T_camera_object = Eigen::Isometry3d::Identity();
  T_camera_object.translate(Eigen::Vector3d(0.05, 0.02, 0.8));
  T_camera_object.rotate(Eigen::AngleAxisd(0.8, Eigen::Vector3d(1.0, 0.7, 0.3).normalized()));

  // The nearest point in each pixel's direction is what a camera sees.
  constexpr int kWidth = 320;
  constexpr int kHeight = 240;
  constexpr double kFocalLength = 290.0;
  binpick::PointCloud scan;
  scan.width = kWidth;
  scan.height = kHeight;
  scan.points.assign(std::size_t{kWidth} * kHeight, Eigen::Vector3f::Constant(NAN));
  for (const Eigen::Vector3f& point : binpick::sample_surface(mesh, 400'000, 1).points) {
    const Eigen::Vector3f p = (T_camera_object * point.cast<double>()).cast<float>();
    const auto u = static_cast<int>(std::lround(kFocalLength * p.x() / p.z() + 0.5 * kWidth));
    const auto v = static_cast<int>(std::lround(kFocalLength * p.y() / p.z() + 0.5 * kHeight));
    if (u < 0 || v < 0 || u >= kWidth || v >= kHeight) continue;
    Eigen::Vector3f& seen = scan.points[static_cast<std::size_t>(v) * kWidth + std::size_t(u)];
    if (!(seen.z() < p.z())) seen = p;
  }
  binpick::write_ply(argv[2], scan);
}
