#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <numeric>
#include <vector>

#include "recognition/thread_team.h"

namespace binpick {

/// Calls work(i) for i in [0, count) on up to `jobs` threads. Each index owns what it writes, so
/// results cannot depend on the number of threads. `work` must not throw.
template <class Work>
void parallel_for(int count, int jobs, const Work& work) {
  const int threads = std::min(jobs, count);
  if (threads <= 1) {
    for (int i = 0; i < count; ++i) work(i);
    return;
  }
  std::atomic<int> next{0};
  const auto drain = [&] {
    for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) work(i);
  };
  ThreadTeam::shared().run(threads - 1, drain);
}

/// As parallel_for over [0, costs.size()), what is expected to take longest first, so that no
/// thread is left alone with it in the end.
template <class Cost, class Work>
void parallel_for_longest_first(const std::vector<Cost>& costs, int jobs, const Work& work) {
  std::vector<int> order(costs.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return costs[static_cast<std::size_t>(a)] > costs[static_cast<std::size_t>(b)];
  });
  parallel_for(static_cast<int>(order.size()), jobs,
               [&](int i) { work(order[static_cast<std::size_t>(i)]); });
}

/// As parallel_for, over [0, size) in chunks: work(chunk, begin, end).
template <class Work>
void parallel_chunks(int size, int chunk_size, int jobs, const Work& work) {
  const int chunks = (size + chunk_size - 1) / chunk_size;
  parallel_for(chunks, jobs, [&](int chunk) {
    const int begin = chunk * chunk_size;
    work(chunk, begin, std::min(size, begin + chunk_size));
  });
}

}  // namespace binpick
