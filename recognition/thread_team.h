#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <vector>

namespace binpick {

/// Threads that are kept for the life of the process and wait for work: one recognition runs dozens
/// of loops of a fraction of a millisecond, and a thread started for each would cost more than it
/// brings. For the same reason a thread without work looks out for more for a fraction of a
/// millisecond before it sleeps: to be woken takes about as long as many a loop. Any number of
/// threads may call run() at the same time, also from within work: whoever waits for the others to
/// return helps meanwhile with what was run from within the same work.
///
/// In a forked child the team has no threads of its own: work is then done by the caller alone.
class ThreadTeam {
 public:
  /// The team of this process.
  static ThreadTeam& shared();

  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  /// Calls work() on the calling thread and, as far as they come in time, on up to `helpers`
  /// others; returns when every call has returned. `work` must not throw.
  void run(int helpers, const std::function<void()>& work);

 private:
  struct Job {
    const std::function<void()>* work;
    int wanted;                // helpers that may still join
    std::atomic<int> running;  // helpers at it; changed under the mutex
    const Job* outermost;      // that it was run from within, or itself
  };

  ThreadTeam() = default;
  ~ThreadTeam() = default;

  void start_threads(int helpers);
  void serve();
  /// Helps with an open job. `lock` holds the mutex, before and after.
  void join(Job& job, std::unique_lock<std::mutex>& lock);
  static void work_on(const Job& job);
  /// An open job with the same outermost one, or nullptr. To be called under the mutex.
  [[nodiscard]] Job* open_kin_of(const Job& job) const;

  static thread_local const Job* at_work_for_;  // outermost job of the calling thread
  std::mutex mutex_;
  std::condition_variable changed_;   // a job was posted or finished
  std::vector<Job*> open_;            // jobs that want helpers, oldest first
  std::atomic<bool> is_open_{false};  // whether there are any; changed under the mutex
  int threads_ = 0;
};

}  // namespace binpick
