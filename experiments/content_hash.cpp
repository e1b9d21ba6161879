#include "experiments/content_hash.h"

#include <fmt/format.h>

#include <array>
#include <fstream>

#include "models/errors.h"

namespace binpick {

void ContentHash::add(std::string_view bytes) noexcept {
  for (const char byte : bytes) {
    state_ ^= static_cast<unsigned char>(byte);
    state_ *= 0x100000001b3u;
  }
}

void ContentHash::add_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) {
    throw InputError(fmt::format("{}: cannot be read, check path and rights", file.string()));
  }
  std::array<char, 65536> block{};
  std::uint64_t size = 0;
  while (stream.read(block.data(), block.size()), stream.gcount() > 0) {
    const auto count = static_cast<std::size_t>(stream.gcount());
    add({block.data(), count});
    size += count;
  }
  add(fmt::format("#{}", size));
}

std::string ContentHash::hex() const { return fmt::format("{:016x}", state_); }

}  // namespace binpick
