#include "models/point_file_format.h"

#include "models/input_bytes.h"
#include "models/pcd_file.h"
#include "models/ply_file.h"
#include "models/vtk_file.h"

namespace binpick {

SurfaceData read_point_file(const std::filesystem::path& file) {
  InputBytes in(file);
  const std::string_view begin = in.rest();
  if (begin.starts_with("ply")) return read_ply(in);
  if (begin.starts_with("# vtk")) return read_vtk(in);
  if (begin.starts_with("# .PCD") || begin.starts_with("VERSION") || begin.starts_with("FIELDS")) {
    return read_pcd(in);
  }
  in.fail_text(0, "neither PLY nor PCD nor legacy VTK; convert the points to one of them");
}

}  // namespace binpick
