#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace binpick {

/// FNV-1a over bytes, 64 bits: tells contents apart, resists no attacker.
class ContentHash {
 public:
  void add(std::string_view bytes) noexcept;
  /// The bytes of a file and their number.
  /// @throws InputError when it cannot be read.
  void add_file(const std::filesystem::path& file);
  /// 16 hexadecimal digits.
  [[nodiscard]] std::string hex() const;

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

}  // namespace binpick
