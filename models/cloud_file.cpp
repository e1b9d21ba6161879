#include "models/cloud_file.h"

#include <fmt/format.h>

#include <bit>
#include <fstream>

#include "models/errors.h"
#include "models/point_file_format.h"
#include "models/surface_data.h"

namespace binpick {

PointCloud read_cloud(const std::filesystem::path& file, double unit) {
  return to_cloud(read_point_file(file), unit);
}

void write_ply(const std::filesystem::path& file, const PointCloud& cloud) {
  static_assert(std::endian::native == std::endian::little, "PLY is written as memory lies");
  const bool with_normals = cloud.has_normals() && !cloud.points.empty();
  std::string body;
  std::size_t count = 0;
  const auto append = [&body](const Eigen::Vector3f& v) {
    body.append(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
  };
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite()) continue;
    append(cloud.points[i]);
    if (with_normals) append(cloud.normals[i]);
    ++count;
  }
  std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n",
      count);
  if (with_normals) header += "property float nx\nproperty float ny\nproperty float nz\n";
  header += "end_header\n";
  std::ofstream stream(file, std::ios::binary);
  stream << header << body;
  stream.close();
  if (!stream) throw IoError(fmt::format("{}: cannot be written", file.string()));
}

}  // namespace binpick
