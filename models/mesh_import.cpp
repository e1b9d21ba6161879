#include "models/mesh_import.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "models/contained_process.h"
#include "models/errors.h"

namespace binpick {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 256u << 20;

void check_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("{}: no such file; give a mesh (OBJ, STL or PLY)", file.string()));
  }
  if (std::filesystem::file_size(file, error) > kMaxFileBytes) {
    throw InputError(fmt::format("{}: larger than 256 MB; simplify the mesh", file.string()));
  }
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".obj" && extension != ".stl" && extension != ".ply") {
    throw InputError(fmt::format("{}: not a mesh format; give OBJ, STL or PLY", file.string()));
  }
}

/// What a child process sends: counts, then coordinates and indices.
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
    if (count > 0) std::memcpy(values, bytes_.data() + position_, count * sizeof(T));
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
  std::vector<float> coordinates;
  std::vector<std::int32_t> indices;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto first = static_cast<std::int32_t>(coordinates.size() / 3);
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& v = part.mVertices[i];
      coordinates.insert(coordinates.end(), {v.x, v.y, v.z});
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      for (unsigned k = 0; k < 3; ++k) {
        indices.push_back(first + static_cast<std::int32_t>(face.mIndices[k]));
      }
    }
  }
  const std::uint64_t counts[2] = {coordinates.size(), indices.size()};
  out.put(counts, 2);
  out.put(coordinates.data(), coordinates.size());
  out.put(indices.data(), indices.size());
}

/// One vertex per place; no triangle without area.
TriangleMesh weld(const std::vector<float>& coordinates, const std::vector<std::int32_t>& indices,
                  double unit, const std::filesystem::path& file) {
  TriangleMesh mesh;
  std::map<std::array<float, 3>, std::int32_t> index_of_place;
  std::vector<std::int32_t> welded(coordinates.size() / 3);
  for (std::size_t i = 0; i < welded.size(); ++i) {
    // -0 and 0 are the same place.
    const std::array<float, 3> place{coordinates[3 * i] + 0.0f, coordinates[3 * i + 1] + 0.0f,
                                     coordinates[3 * i + 2] + 0.0f};
    if (!std::isfinite(place[0]) || !std::isfinite(place[1]) || !std::isfinite(place[2])) {
      throw InputError(
          fmt::format("{}: vertex {} is not finite; repair the mesh", file.string(), i));
    }
    const auto [entry, inserted] =
        index_of_place.try_emplace(place, static_cast<std::int32_t>(mesh.vertices.size()));
    if (inserted) {
      mesh.vertices.emplace_back(unit * static_cast<double>(place[0]),
                                 unit * static_cast<double>(place[1]),
                                 unit * static_cast<double>(place[2]));
    }
    welded[i] = entry->second;
  }
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    std::array<std::int32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t index = indices[i + k];
      if (index < 0 || static_cast<std::size_t>(index) >= welded.size()) {
        throw InputError(fmt::format("{}: triangle {} names vertex {}, which does not exist",
                                     file.string(), i / 3, index));
      }
      triangle[k] = welded[static_cast<std::size_t>(index)];
    }
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(triangle[0])];
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(triangle[1])];
    const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(triangle[2])];
    if ((b - a).cross(c - a).squaredNorm() > 0.0) mesh.triangles.push_back(triangle);
  }
  if (mesh.triangles.empty()) {
    throw InputError(fmt::format("{}: no triangles; give a mesh with a surface", file.string()));
  }
  return mesh;
}

}  // namespace

std::vector<TriangleMesh> import_meshes(const std::vector<std::filesystem::path>& files,
                                        double unit) {
  if (files.empty()) return {};
  for (const std::filesystem::path& file : files) check_file(file);
  const ContainedResult result = run_contained([&files] {
    ByteWriter out;
    for (const std::filesystem::path& file : files) append_with_assimp(file, out);
    return out.take();
  });
  if (!result.ok) {
    // A crash does not say which of several files was at fault; one at a time it does.
    if (files.size() > 1) {
      for (const std::filesystem::path& file : files) static_cast<void>(import_mesh(file, unit));
    }
    const std::string name = files.front().string();
    throw InputError(result.problem.starts_with(name)
                         ? result.problem
                         : fmt::format("{}: {}; repair the mesh", name, result.problem));
  }
  ByteReader in(result.bytes);
  std::vector<TriangleMesh> meshes;
  for (const std::filesystem::path& file : files) {
    std::uint64_t counts[2] = {};
    in.get(counts, 2);
    std::vector<float> coordinates(counts[0]);
    std::vector<std::int32_t> indices(counts[1]);
    in.get(coordinates.data(), coordinates.size());
    in.get(indices.data(), indices.size());
    meshes.push_back(weld(coordinates, indices, unit, file));
  }
  return meshes;
}

TriangleMesh import_mesh(const std::filesystem::path& file, double unit) {
  return std::move(import_meshes({file}, unit).front());
}

}  // namespace binpick
