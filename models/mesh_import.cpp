#include "models/mesh_import.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstring>
#include <string>

#include "models/contained_process.h"
#include "models/errors.h"
#include "models/input_bytes.h"
#include "models/ply_file.h"
#include "models/surface_data.h"

namespace binpick {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 256u << 20;

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void check_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("{}: no such file; give a mesh (OBJ, STL or PLY)", file.string()));
  }
  if (std::filesystem::file_size(file, error) > kMaxFileBytes) {
    throw InputError(fmt::format("{}: larger than 256 MB; simplify the mesh", file.string()));
  }
  const std::string extension = lower_extension(file);
  if (extension != ".obj" && extension != ".stl" && extension != ".ply") {
    throw InputError(fmt::format("{}: not a mesh format; give OBJ, STL or PLY", file.string()));
  }
}

/// What the child process sends: counts, then points and triangles.
class ByteWriter {
 public:
  template <class T>
  void put(const T* values, std::size_t count) {
    const auto* first = reinterpret_cast<const std::byte*>(values);
    bytes_.insert(bytes_.end(), first, first + count * sizeof(T));
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(const std::vector<std::byte>& bytes) : bytes_(bytes) {}
  template <class T>
  void get(T* values, std::size_t count) {
    if (count > (bytes_.size() - position_) / sizeof(T)) {
      throw InputError("the mesh importer's answer is too short");
    }
    if (count > 0)
      std::memcpy(static_cast<void*>(values), bytes_.data() + position_, count * sizeof(T));
    position_ += count * sizeof(T);
  }

 private:
  const std::vector<std::byte>& bytes_;
  std::size_t position_ = 0;
};

/// Runs in the child.
void append_with_assimp(const std::filesystem::path& file, ByteWriter& out) {
  Assimp::Importer importer;
  // Points and lines have no surface.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  if (scene == nullptr) {
    throw InputError(fmt::format("{}: {}", file.string(), importer.GetErrorString()));
  }
  std::vector<Eigen::Vector3f> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto first = static_cast<std::int32_t>(points.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& v = part.mVertices[i];
      points.emplace_back(v.x, v.y, v.z);
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      const auto corner = [&](unsigned k) {
        return first + static_cast<std::int32_t>(face.mIndices[k]);
      };
      triangles.push_back({corner(0), corner(1), corner(2)});
    }
  }
  const std::uint64_t counts[2] = {points.size(), triangles.size()};
  out.put(counts, 2);
  out.put(points.data(), points.size());
  out.put(triangles.data(), triangles.size());
}

/// Generous for files of this size: assimp 5.2 reads an OBJ of 36 MB in 0.5 s and holds it in 240
/// MB. A small file that hangs or swells is stopped in less than a second.
ContainmentLimits limits_for(const std::vector<std::filesystem::path>& files) {
  std::uintmax_t bytes = 0;
  std::error_code ignored;
  for (const std::filesystem::path& file : files)
    bytes += std::filesystem::file_size(file, ignored);
  ContainmentLimits limits;
  limits.cpu_seconds = 0.7 + 0.2e-6 * static_cast<double>(bytes);
  limits.wall_seconds = 20.0 * limits.cpu_seconds;
  limits.memory_bytes = (std::size_t{256} << 20) + 30 * bytes;
  limits.output_bytes = limits.memory_bytes;
  return limits;
}

/// The files' surfaces by assimp, in one child process.
std::vector<SurfaceData> import_with_assimp(const std::vector<std::filesystem::path>& files) {
  if (files.empty()) return {};
  const ContainedResult result = run_contained(
      [&files] {
        ByteWriter out;
        for (const std::filesystem::path& file : files) append_with_assimp(file, out);
        return out.take();
      },
      limits_for(files));
  if (!result.ok) {
    // A crash does not say which of several files was at fault; one at a time it does.
    if (files.size() > 1) {
      for (const std::filesystem::path& file : files) static_cast<void>(import_with_assimp({file}));
    }
    const std::string name = files.front().string();
    throw InputError(result.problem.starts_with(name)
                         ? result.problem
                         : fmt::format("{}: {}; repair the mesh", name, result.problem));
  }
  ByteReader in(result.bytes);
  std::vector<SurfaceData> surfaces(files.size());
  for (SurfaceData& surface : surfaces) {
    std::uint64_t counts[2] = {};
    in.get(counts, 2);
    if (std::max(counts[0], counts[1]) > result.bytes.size()) {
      throw InputError(
          fmt::format("{}: the mesh importer's answer is damaged", files.front().string()));
    }
    surface.points.resize(counts[0]);
    surface.triangles.resize(counts[1]);
    in.get(surface.points.data(), surface.points.size());
    in.get(surface.triangles.data(), surface.triangles.size());
  }
  return surfaces;
}

}  // namespace

std::vector<TriangleMesh> import_meshes(const std::vector<std::filesystem::path>& files,
                                        double unit) {
  std::vector<std::filesystem::path> foreign;
  for (const std::filesystem::path& file : files) {
    check_file(file);
    if (lower_extension(file) != ".ply") foreign.push_back(file);
  }
  const std::vector<SurfaceData> imported = import_with_assimp(foreign);
  std::vector<TriangleMesh> meshes;
  std::size_t next = 0;
  for (const std::filesystem::path& file : files) {
    if (lower_extension(file) == ".ply") {
      InputBytes in(file);
      meshes.push_back(to_mesh(read_ply(in), unit, file.string()));
    } else {
      meshes.push_back(to_mesh(imported[next++], unit, file.string()));
    }
  }
  return meshes;
}

TriangleMesh import_mesh(const std::filesystem::path& file, double unit) {
  return std::move(import_meshes({file}, unit).front());
}

}  // namespace binpick
