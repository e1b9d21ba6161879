#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>

namespace binpick {

using Seed = std::uint64_t;

/// Derives an independent seed for `purpose` from `parent`. Chains express the house rule
/// hash(master, experiment, cell, trial, purpose); adding a purpose moves no other draw.
[[nodiscard]] Seed derive_seed(Seed parent, std::string_view purpose) noexcept;
[[nodiscard]] Seed derive_seed(Seed parent, std::uint64_t index) noexcept;

/// Counter-based generator: draw number i is a hash of (seed, i), so a stream can be entered at any
/// index and parallel work can own its draws by index. Philox-2x64 with ten rounds
/// (Salmon et al., SC 2011).
class Random {
 public:
  explicit Random(Seed seed, std::uint64_t first_draw = 0) noexcept
      : seed_(seed), counter_(first_draw) {}

  [[nodiscard]] std::uint64_t bits() noexcept;
  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform() noexcept;
  [[nodiscard]] double uniform(double low, double high) noexcept;
  /// Uniform in {0, ..., size - 1}; `size` > 0. Free of modulo bias to 2^-64.
  [[nodiscard]] std::uint64_t index(std::uint64_t size) noexcept;
  /// Standard normal (Box-Muller, both draws consumed every time).
  [[nodiscard]] double normal() noexcept;
  [[nodiscard]] Eigen::Vector3d unit_vector() noexcept;
  /// Uniform over SO(3) (Shoemake).
  [[nodiscard]] Eigen::Quaterniond rotation() noexcept;

 private:
  Seed seed_;
  std::uint64_t counter_;
};

}  // namespace binpick
