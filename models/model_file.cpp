#include "models/model_file.h"

#include <cctype>
#include <string>

#include "models/mesh_import.h"
#include "models/point_file_format.h"
#include "models/surface_data.h"

namespace binpick {

ModelGeometry read_model_file(const std::filesystem::path& file, double unit) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".obj" || extension == ".stl") return import_mesh(file, unit);

  const SurfaceData data = read_point_file(file);
  if (data.triangles.empty()) return to_cloud(data, unit);
  return to_mesh(data, unit, file.string());
}

}  // namespace binpick
