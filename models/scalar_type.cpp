#include "models/scalar_type.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace binpick {
namespace {

template <class T>
T value_at(const char* data, std::endian order) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), data, sizeof(T));
  if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Calls `use` with a value of the C++ type that `type` stands for.
template <class Use>
decltype(auto) with_type(ScalarType type, const Use& use) {
  using Kind = ScalarType::Kind;
  const bool is_signed = type.kind == Kind::kSigned;
  switch (type.size) {
    case 1:
      return is_signed ? use(std::int8_t{}) : use(std::uint8_t{});
    case 2:
      return is_signed ? use(std::int16_t{}) : use(std::uint16_t{});
    case 4:
      if (type.kind == Kind::kFloat) return use(float{});
      return is_signed ? use(std::int32_t{}) : use(std::uint32_t{});
    default:
      if (type.kind == Kind::kFloat) return use(double{});
      return is_signed ? use(std::int64_t{}) : use(std::uint64_t{});
  }
}

}  // namespace

double read_scalar(const char* data, ScalarType type, std::endian order) {
  return with_type(type, [&](auto zero) -> double {
    return static_cast<double>(value_at<decltype(zero)>(data, order));
  });
}

std::vector<Eigen::Vector3f> read_triples(std::string_view bytes,
                                          const std::array<PackedColumn, 3>& columns,
                                          std::size_t count, std::endian order) {
  // Column by column within blocks that stay in the cache: the type is looked at once per block.
  constexpr std::size_t kBlock = 1024;
  std::vector<Eigen::Vector3f> triples(count);
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, count);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PackedColumn& column = columns[axis];
      const char* const data = bytes.data() + column.offset;
      with_type(column.type, [&](auto zero) {
        for (std::size_t i = begin; i < end; ++i) {
          triples[i][static_cast<Eigen::Index>(axis)] =
              static_cast<float>(value_at<decltype(zero)>(data + i * column.stride, order));
        }
      });
    }
  }
  return triples;
}

}  // namespace binpick
