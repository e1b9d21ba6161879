#include "fuzz_surface.h"
#include "models/pcd_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  binpick::fuzz_surface_reader(&binpick::read_pcd, data, size);
  return 0;
}
