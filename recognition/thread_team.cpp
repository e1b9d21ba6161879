#include "recognition/thread_team.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

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

thread_local const ThreadTeam::Job* ThreadTeam::at_work_for_ = nullptr;

ThreadTeam& ThreadTeam::shared() {
  // Never destroyed: its threads may still wait in it while the process ends.
  static ThreadTeam& team = *new ThreadTeam;
  return team;
}

void ThreadTeam::run(int helpers, const std::function<void()>& work) {
  Job job{&work, helpers, 0, nullptr};
  job.outermost = at_work_for_ != nullptr ? at_work_for_ : &job;
  {
    const std::lock_guard lock(mutex_);
    start_threads(helpers);
    open_.push_back(&job);
    is_open_ = true;
  }
  changed_.notify_all();
  work_on(job);
  {
    const std::lock_guard lock(mutex_);
    std::erase(open_, &job);
    is_open_ = !open_.empty();
  }
  const auto is_finished = [&] { return job.running == 0; };
  for (;;) {
    comes_soon([&] { return is_finished() || is_open_; });
    if (is_finished()) return;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return is_finished() || open_kin_of(job) != nullptr; });
    if (is_finished()) return;
    join(*open_kin_of(job), lock);
  }
}

void ThreadTeam::start_threads(int helpers) {
  for (; threads_ < helpers; ++threads_) std::thread([this] { serve(); }).detach();
}

void ThreadTeam::serve() {
  for (;;) {
    comes_soon([&] { return is_open_.load(); });
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !open_.empty(); });
    join(*open_.front(), lock);
  }
}

void ThreadTeam::join(Job& job, std::unique_lock<std::mutex>& lock) {
  if (--job.wanted == 0) {
    std::erase(open_, &job);
    is_open_ = !open_.empty();
  }
  ++job.running;
  lock.unlock();
  work_on(job);
  lock.lock();
  // Once none is running, the job may be gone.
  if (--job.running == 0) changed_.notify_all();
}

void ThreadTeam::work_on(const Job& job) {
  const Job* const before = std::exchange(at_work_for_, job.outermost);
  (*job.work)();
  at_work_for_ = before;
}

ThreadTeam::Job* ThreadTeam::open_kin_of(const Job& job) const {
  const auto kin = std::find_if(open_.begin(), open_.end(), [&](const Job* other) {
    return other->outermost == job.outermost;
  });
  return kin == open_.end() ? nullptr : *kin;
}

}  // namespace binpick
