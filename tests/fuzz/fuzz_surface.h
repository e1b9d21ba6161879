#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "models/errors.h"
#include "models/input_bytes.h"
#include "models/surface_data.h"

namespace binpick {

/// Reads `data` as a file of one format and on to the cloud or the mesh that a program would use.
/// An InputError is a good answer; all else that a reader does to be rid of its input is a finding.
inline void fuzz_surface_reader(SurfaceData (*read)(InputBytes&), const std::uint8_t* data,
                                std::size_t size) {
  try {
    InputBytes in(std::string_view(reinterpret_cast<const char*>(data), size), "fuzzed");
    SurfaceData surface = read(in);
    if (!surface.triangles.empty()) static_cast<void>(to_mesh(surface, 0.001, "fuzzed"));
    static_cast<void>(to_cloud(std::move(surface), 0.001));
  } catch (const InputError&) {
  }
}

}  // namespace binpick
