#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace binpick {

/// Bounds for work whose input is not trusted.
struct ContainmentLimits {
  double cpu_seconds = 10.0;            ///< processor time; what ends a loop without end
  double wall_seconds = 30.0;           ///< what ends a wait; generous, as machines may be busy
  std::size_t memory_bytes = 1u << 30;  ///< address space beyond what the process has already
  std::size_t output_bytes = 1u << 30;  ///< of the answer
};

struct ContainedResult {
  bool ok = false;
  std::vector<std::byte> bytes;  ///< the answer when ok
  std::string problem;           ///< why not, when not ok: "crashed (signal 11)", ...
};

/// Runs `work` in a forked child and returns its answer. A crash, an endless loop or a greedy
/// allocation ends the child alone; an exception's text comes back as the problem. Thread-safe; the
/// child must not wait for other threads.
[[nodiscard]] ContainedResult run_contained(const std::function<std::vector<std::byte>()>& work,
                                            const ContainmentLimits& limits = {});

}  // namespace binpick
