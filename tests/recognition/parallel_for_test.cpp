#include "recognition/parallel_for.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace binpick {
namespace {

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const int jobs : {1, 2, 5}) {
    for (const int count : {0, 1, 2, 1000}) {
      std::vector<int> visits(static_cast<std::size_t>(count), 0);
      parallel_for(count, jobs, [&](int i) { ++visits[static_cast<std::size_t>(i)]; });
      EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(count), 1))
          << count << " indices, " << jobs << " jobs";
    }
  }
}

TEST(ParallelFor, WorksOnSeveralThreadsAtATime) {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  parallel_for(3, 3, [&](int) {
    // Long enough for the others to come.
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(threads.size(), 3U);
}

TEST(ParallelFor, MayBeCalledFromItsOwnWork) {
  std::array<std::array<int, 8>, 8> visits{};
  parallel_for(8, 3, [&](int i) {
    auto& row = visits[static_cast<std::size_t>(i)];
    parallel_for(8, 3, [&](int k) { ++row[static_cast<std::size_t>(k)]; });
  });
  for (const auto& row : visits) {
    for (const int count : row) EXPECT_EQ(count, 1);
  }
}

TEST(ParallelFor, WhoWaitsForItsOwnWorkHelpsWithWhatThatCalls) {
  constexpr int kMany = 8;  // more than the team has threads
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> other_came{false};
  std::atomic<bool> caller_helped{false};
  parallel_for(2, 2, [&](int) {
    if (std::this_thread::get_id() == caller) {
      while (!other_came) std::this_thread::yield();
      return;
    }
    other_came = true;
    parallel_for(kMany, kMany, [&](int) {
      // Long enough for all to come.
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      if (std::this_thread::get_id() == caller) caller_helped = true;
    });
  });
  EXPECT_TRUE(caller_helped);
}

TEST(ParallelFor, MayBeCalledFromSeveralThreads) {
  constexpr int kCalls = 200;
  std::array<long, 4> sums{};
  std::vector<std::jthread> callers;
  for (long& sum : sums) {
    callers.emplace_back([&sum] {
      for (int call = 0; call < kCalls; ++call) {
        std::array<long, 16> parts{};
        parallel_for(16, 2, [&](int i) { parts[static_cast<std::size_t>(i)] = i; });
        for (const long part : parts) sum += part;
      }
    });
  }
  callers.clear();
  for (const long sum : sums) EXPECT_EQ(sum, 120L * kCalls);
}

TEST(ParallelFor, BeginsWithWhatTakesLongest) {
  const std::vector<int> costs = {2, 5, 1, 5};
  std::vector<int> order;
  parallel_for_longest_first(costs, 1, [&](int i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<int>{1, 3, 0, 2}));
}

TEST(ParallelChunks, TheLastChunkIsTheRest) {
  std::array<int, 3> sizes{};
  parallel_chunks(10, 4, 2, [&](int chunk, int begin, int end) {
    sizes[static_cast<std::size_t>(chunk)] = end - begin;
  });
  EXPECT_EQ(sizes, (std::array<int, 3>{4, 4, 2}));
}

}  // namespace
}  // namespace binpick
