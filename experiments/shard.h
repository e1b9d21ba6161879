#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "experiments/experiment.h"

namespace binpick {

/// One of `count` equal parts of a sweep, for running on several machines. Which trials belong to
/// it depends on nothing but their own numbers.
struct Shard {
  std::int64_t index = 0;  ///< from 0
  std::int64_t count = 1;

  /// Every shard holds trials of every cell.
  [[nodiscard]] bool holds(const Job& job) const {
    return (static_cast<std::int64_t>(job.cell) + job.trial) % count == index;
  }
  /// From `i/n` with 0 <= i < n.
  /// @throws InputError for anything else.
  [[nodiscard]] static Shard parse(const std::string& text);
  /// From the environment of a Slurm job array (SLURM_ARRAY_TASK_ID, _MIN, _COUNT); nothing
  /// outside of one.
  [[nodiscard]] static std::optional<Shard> from_environment();
};

}  // namespace binpick
