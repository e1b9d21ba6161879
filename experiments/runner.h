#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/result_store.h"
#include "experiments/stop_signals.h"
#include "experiments/worker_process.h"

namespace binpick {

/// What a run tells its owner, always from the thread that called Runner::run.
struct RunEvents {
  /// The first worker has loaded everything: results may now be written. Called once, first.
  std::function<void()> inputs_accepted;
  /// A trial has ended. May throw: the workers are stopped and the exception goes on.
  std::function<void(const TrialKey&, const StoredTrial&)> trial_finished;
  /// A line that a worker printed.
  std::function<void(std::string_view)> log;
  /// All jobs have ended: more of them, or none to end the run. May be left empty.
  std::function<std::vector<Job>()> more_jobs;
  /// At least twice a second.
  std::function<void()> tick;
};

struct RunnerOptions {
  int workers = 1;
  std::filesystem::path folder;  ///< the workers' working folder
};

/// Runs jobs in worker processes, each on one job at a time. Records depend on the job alone, so
/// neither the number of workers nor their order matters. A worker takes the cells of one trial
/// number in turn as long as it can: they often share a pile or a scan, which it keeps.
///
/// A worker that dies during a trial is replaced and the trial tried again: a trial that kills its
/// process does so again and is booked as kCrashed, whereas a worker killed from outside (by a
/// person, or by the kernel when memory is short) costs nothing. A trial that spends more processor
/// time than the experiment's time limit, or ten times as much on the wall clock, is killed and
/// booked as kTimeout: a busy machine makes no trial fail. Time during which this process was
/// stopped (SIGSTOP, a suspended job) does not count.
class Runner {
 public:
  Runner(const Experiment& experiment, std::vector<Job> jobs, RunnerOptions options,
         RunEvents events);

  /// Runs until all jobs have ended or a stop signal arrives; trials in flight are then abandoned.
  /// @return the signal.
  /// @throws InputError when a worker cannot use configuration or files, std::runtime_error when
  /// workers cannot even load.
  [[nodiscard]] std::optional<int> run();

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { kLoading, kIdle, kRunning, kEnded };

  struct PendingJob {
    Job job;
    int deaths = 0;  ///< of workers, so far
  };
  struct Slot {
    WorkerProcess process;
    State state = State::kLoading;
    bool log_open = true;
    PendingJob work;
    std::optional<std::size_t> group;  ///< that its work comes from
    TrialStage stage = TrialStage::kSetup;
    Clock::time_point started = Clock::now();
    double processor_time = 0.0;  ///< of the worker when the trial began, s
  };

  void start_worker();
  [[nodiscard]] int poll_timeout_ms() const;
  /// @return whether there is something to do, after asking for more when all jobs have ended.
  [[nodiscard]] bool has_work();
  /// Starts workers that are missing and gives work to those that are idle.
  void fill_slots();
  /// Waits for something to happen. @return the stop signal, if that was it.
  std::optional<int> wait_for_events();
  void handle_replies(Slot& slot);
  void handle_reply(Slot& slot, const WorkerReply& reply);
  void handle_log(Slot& slot);
  void handle_end(Slot& slot);
  void handle_death(const Slot& slot, const ProcessEnd& end);
  void check_deadline(Slot& slot);
  void forgive_pause();
  void accept_inputs();
  void give_work(Slot& slot);
  void finish(const Job& job, TrialRecord record, Clock::time_point started);
  /// Wall-clock time for what the worker is doing.
  [[nodiscard]] Clock::duration patience_with(const Slot& slot) const;
  [[nodiscard]] std::optional<PendingJob> take_job(Slot& slot);
  void group_jobs();
  [[nodiscard]] std::size_t next_group() const;

  /// Jobs of one trial number, by their place in `jobs_`.
  struct Group {
    std::size_t next = 0;
    std::size_t end = 0;
    bool begun = false;
    [[nodiscard]] std::size_t left() const { return end - next; }
  };

  const Experiment& experiment_;
  std::vector<Job> jobs_;  ///< by trial number
  std::vector<Group> groups_;
  RunnerOptions options_;
  RunEvents events_;
  StopSignals stop_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::vector<PendingJob> repeats_;
  std::size_t unfinished_;
  bool inputs_accepted_ = false;
  Clock::time_point last_turn_ = Clock::now();
  int load_deaths_ = 0;  ///< of workers that were killed from outside while they loaded
};

}  // namespace binpick
