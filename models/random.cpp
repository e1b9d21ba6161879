#include "models/random.h"

#include <cmath>
#include <numbers>

namespace binpick {
namespace {

struct WideProduct {
  std::uint64_t high;
  std::uint64_t low;
};

WideProduct multiply_wide(std::uint64_t a, std::uint64_t b) noexcept {
  __extension__ using Wide = unsigned __int128;
  const Wide product = static_cast<Wide>(a) * b;
  return {static_cast<std::uint64_t>(product >> 64), static_cast<std::uint64_t>(product)};
}

std::uint64_t philox(std::uint64_t key, std::uint64_t counter, std::uint64_t stream) noexcept {
  constexpr std::uint64_t kMultiplier = 0xD2B74407B1CE6E93u;
  constexpr std::uint64_t kWeyl = 0x9E3779B97F4A7C15u;
  std::uint64_t left = counter;
  std::uint64_t right = stream;
  for (int round = 0; round < 10; ++round) {
    const WideProduct product = multiply_wide(left, kMultiplier);
    left = product.high ^ key ^ right;
    right = product.low;
    key += kWeyl;
  }
  return left;
}

// Streams keep derived seeds apart from draws.
constexpr std::uint64_t kDrawStream = 0;
constexpr std::uint64_t kNameStream = 1;
constexpr std::uint64_t kIndexStream = 2;

}  // namespace

Seed derive_seed(Seed parent, std::string_view purpose) noexcept {
  std::uint64_t fnv = 0xCBF29CE484222325u;
  for (const char character : purpose) {
    fnv = (fnv ^ static_cast<unsigned char>(character)) * 0x100000001B3u;
  }
  return philox(parent, fnv, kNameStream);
}

Seed derive_seed(Seed parent, std::uint64_t index) noexcept {
  return philox(parent, index, kIndexStream);
}

std::uint64_t Random::bits() noexcept { return philox(seed_, counter_++, kDrawStream); }

double Random::uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }

double Random::uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

std::uint64_t Random::index(std::uint64_t size) noexcept {
  return multiply_wide(bits(), size).high;
}

double Random::normal() noexcept {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

Eigen::Vector3d Random::unit_vector() noexcept {
  const double z = uniform(-1.0, 1.0);
  const double azimuth = uniform(0.0, 2.0 * std::numbers::pi);
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(azimuth), radius * std::sin(azimuth), z};
}

Eigen::Quaterniond Random::rotation() noexcept {
  const double split = uniform();
  const double alpha = uniform(0.0, 2.0 * std::numbers::pi);
  const double beta = uniform(0.0, 2.0 * std::numbers::pi);
  const double a = std::sqrt(1.0 - split);
  const double b = std::sqrt(split);
  return {b * std::cos(beta), a * std::sin(alpha), a * std::cos(alpha), b * std::sin(beta)};
}

}  // namespace binpick
