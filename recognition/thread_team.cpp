#include "recognition/thread_team.h"

#include <algorithm>
#include <thread>

namespace binpick {

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
  }
  posted_.notify_all();
  work();
  std::unique_lock lock(mutex_);
  std::erase(open_, &job);
  finished_.wait(lock, [&] { return job.running == 0; });
}

void ThreadTeam::start_threads(int helpers) {
  for (; threads_ < helpers; ++threads_) std::thread([this] { serve(); }).detach();
}

void ThreadTeam::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    posted_.wait(lock, [&] { return !open_.empty(); });
    Job& job = *open_.front();
    if (--job.wanted == 0) open_.erase(open_.begin());
    ++job.running;
    lock.unlock();
    (*job.work)();
    lock.lock();
    if (--job.running == 0) finished_.notify_all();
  }
}

}  // namespace binpick
