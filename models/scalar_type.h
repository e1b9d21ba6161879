#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstddef>
#include <string_view>
#include <vector>

namespace binpick {

/// A number's type in a binary part of a file.
struct ScalarType {
  enum class Kind { kSigned, kUnsigned, kFloat };
  Kind kind = Kind::kFloat;
  std::size_t size = 4;  ///< bytes: 1, 2, 4 or 8; 4 or 8 for kFloat
};

/// Reads one number of `type` at `data`; integers beyond 2^53 lose digits.
[[nodiscard]] double read_scalar(const char* data, ScalarType type, std::endian order);

/// One number of every record: the first lies at `offset`, the next `stride` bytes further on.
struct PackedColumn {
  std::size_t offset = 0;
  std::size_t stride = 0;
  ScalarType type;
};

/// Reads three columns of `count` numbers as vectors. All of them must lie within `bytes`.
[[nodiscard]] std::vector<Eigen::Vector3f> read_triples(std::string_view bytes,
                                                        const std::array<PackedColumn, 3>& columns,
                                                        std::size_t count, std::endian order);

}  // namespace binpick
