#include "fuzz_surface.h"
#include "models/vtk_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  binpick::fuzz_surface_reader(&binpick::read_vtk, data, size);
  return 0;
}
