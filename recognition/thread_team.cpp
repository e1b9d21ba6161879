#include "recognition/thread_team.h"

#include <chrono>
#include <thread>

namespace binpick {
namespace {

/// Waits until `condition` holds, but not long; says whether it does. Gives way to whoever else
/// wants the processor.
template <class Condition>
bool comes_soon(const Condition& condition) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds kPatience(300);
  const Clock::time_point end = Clock::now() + kPatience;
  while (!condition()) {
    if (Clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

}  // namespace

ThreadTeam& ThreadTeam::shared() {
  // Never destroyed: its threads may still wait in it while the process ends.
  static ThreadTeam& team = *new ThreadTeam;
  return team;
}

void ThreadTeam::run(int helpers, const std::function<void()>& work) {
  Job job{&work, helpers, 0};
  {
    const std::lock_guard lock(mutex_);
    start_threads(helpers);
    open_.push_back(&job);
    is_open_ = true;
  }
  posted_.notify_all();
  work();
  {
    const std::lock_guard lock(mutex_);
    std::erase(open_, &job);
    is_open_ = !open_.empty();
  }
  const auto is_finished = [&] { return job.running == 0; };
  if (comes_soon(is_finished)) return;
  std::unique_lock lock(mutex_);
  finished_.wait(lock, is_finished);
}

void ThreadTeam::start_threads(int helpers) {
  for (; threads_ < helpers; ++threads_) std::thread([this] { serve(); }).detach();
}

void ThreadTeam::serve() {
  for (;;) {
    comes_soon([&] { return is_open_.load(); });
    std::unique_lock lock(mutex_);
    posted_.wait(lock, [&] { return !open_.empty(); });
    Job& job = *open_.front();
    if (--job.wanted == 0) {
      open_.erase(open_.begin());
      is_open_ = !open_.empty();
    }
    ++job.running;
    lock.unlock();
    (*job.work)();
    lock.lock();
    // Once none is running, the job may be gone.
    if (--job.running == 0) finished_.notify_all();
  }
}

}  // namespace binpick
