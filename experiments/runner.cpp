#include "experiments/runner.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "models/errors.h"

namespace binpick {
namespace {

using std::chrono::duration;
using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr int kTickMs = 500;
constexpr int kOwnDeaths = 2;  // a trial is booked as crashed after so many deaths
constexpr int kDeathsFromOutside = 6;
constexpr double kPatience = 10.0;         // wall-clock time, by the time limit
constexpr std::chrono::seconds kPause{2};  // a turn of so long means that this process was stopped
constexpr double kLoadLimit = 300.0;  // s; loading is no trial, but must not hang for ever either

}  // namespace

Runner::Runner(const Experiment& experiment, std::vector<Job> jobs, RunnerOptions options,
               RunEvents events)
    : experiment_(experiment),
      jobs_(std::move(jobs)),
      options_(std::move(options)),
      events_(std::move(events)),
      unfinished_(jobs_.size()) {
  group_jobs();
}

std::optional<int> Runner::run() {
  last_turn_ = Clock::now();
  while (has_work()) {
    fill_slots();
    if (const auto signal = wait_for_events()) {
      slots_.clear();  // kills the workers
      return signal;
    }
    for (const auto& slot : slots_) check_deadline(*slot);
    const auto ended = std::remove_if(slots_.begin(), slots_.end(), [](const auto& slot) {
      return slot->state == State::kEnded;
    });
    slots_.erase(ended, slots_.end());
    if (events_.tick) events_.tick();
  }
  slots_.clear();
  return std::nullopt;
}

bool Runner::has_work() {
  if (unfinished_ > 0 || !events_.more_jobs) return unfinished_ > 0;
  jobs_ = events_.more_jobs();
  group_jobs();
  unfinished_ = jobs_.size();
  return unfinished_ > 0;
}

void Runner::fill_slots() {
  for (const auto& slot : slots_) {
    if (slot->state == State::kIdle) give_work(*slot);
  }
  while (slots_.size() < std::min(static_cast<std::size_t>(options_.workers), unfinished_)) {
    start_worker();
  }
}

void Runner::start_worker() {
  auto slot = std::make_unique<Slot>();
  slot->process.send({WorkerOrder::Type::kSetup, experiment_.effective_yaml(),
                      experiment_.directory().string(), "", jobs_.front().cell, 0});
  slots_.push_back(std::move(slot));
}

std::optional<int> Runner::wait_for_events() {
  std::vector<pollfd> descriptors{{stop_.descriptor(), POLLIN, 0}};
  for (const auto& slot : slots_) {
    descriptors.push_back({slot->process.reply_descriptor(), POLLIN, 0});
    descriptors.push_back({slot->log_open ? slot->process.log_descriptor() : -1, POLLIN, 0});
  }
  ::poll(descriptors.data(), descriptors.size(), poll_timeout_ms());
  forgive_pause();  // before any trial begins that the pause does not concern
  if (const auto signal = stop_.received()) return signal;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (descriptors[2 + 2 * i].revents != 0) handle_log(*slots_[i]);
    if (descriptors[1 + 2 * i].revents != 0) handle_replies(*slots_[i]);
  }
  return std::nullopt;
}

int Runner::poll_timeout_ms() const {
  int timeout = kTickMs;
  for (const auto& slot : slots_) {
    if (slot->state == State::kIdle) continue;
    const auto left = slot->started + patience_with(*slot) - Clock::now();
    const auto left_ms = duration_cast<milliseconds>(left).count() + 1;
    timeout = static_cast<int>(std::clamp<std::int64_t>(left_ms, 0, timeout));
  }
  return timeout;
}

Runner::Clock::duration Runner::patience_with(const Slot& slot) const {
  const double seconds =
      slot.state == State::kLoading ? kLoadLimit : kPatience * experiment_.config().time_limit;
  return duration_cast<Clock::duration>(duration<double>(seconds));
}

void Runner::handle_log(Slot& slot) {
  slot.log_open = slot.process.receive_log();
  while (const auto line = slot.process.next_log()) {
    if (events_.log) events_.log(*line);
  }
}

void Runner::handle_replies(Slot& slot) {
  const bool open = slot.process.receive();
  while (const auto line = slot.process.next_reply()) {
    const auto reply = decode_reply(*line);
    if (!reply) throw std::runtime_error("a worker sent a line that is no reply");
    handle_reply(slot, *reply);
  }
  if (!open) handle_end(slot);
}

void Runner::handle_reply(Slot& slot, const WorkerReply& reply) {
  switch (reply.type) {
    case WorkerReply::Type::kReady:
      accept_inputs();
      give_work(slot);
      break;
    case WorkerReply::Type::kStage:
      slot.stage = reply.stage;
      break;
    case WorkerReply::Type::kRecord: {
      const Job job = slot.work.job;
      const Clock::time_point started = slot.started;
      // The worker gets its next trial before the disk is waited for.
      if (reply.ends) {
        slot.state = State::kEnded;
      } else {
        give_work(slot);
      }
      finish(job, reply.record, started);
      break;
    }
    case WorkerReply::Type::kInputError:
      throw InputError(reply.message);
    case WorkerReply::Type::kFailed:
      throw std::runtime_error(fmt::format("a worker could not prepare: {}", reply.message));
  }
}

void Runner::accept_inputs() {
  if (inputs_accepted_) return;
  inputs_accepted_ = true;
  if (events_.inputs_accepted) events_.inputs_accepted();
}

void Runner::group_jobs() {
  std::stable_sort(jobs_.begin(), jobs_.end(),
                   [](const Job& a, const Job& b) { return a.trial < b.trial; });
  groups_.clear();
  for (std::size_t i = 0; i < jobs_.size(); ++i) {
    if (i == 0 || jobs_[i].trial != jobs_[i - 1].trial) groups_.push_back({i, i});
    groups_.back().end = i + 1;
  }
  for (const auto& slot : slots_) slot->group.reset();
}

std::optional<Runner::PendingJob> Runner::take_job(Slot& slot) {
  if (!repeats_.empty()) {
    const PendingJob job = repeats_.back();
    repeats_.pop_back();
    return job;
  }
  if (!slot.group || groups_[*slot.group].left() == 0) slot.group = next_group();
  Group& group = groups_[*slot.group];
  if (group.left() == 0) return std::nullopt;
  group.begun = true;
  return PendingJob{jobs_[group.next++], 0};
}

/// The first that nobody has begun, else the one with the most left to help with.
std::size_t Runner::next_group() const {
  const auto fresh =
      std::find_if(groups_.begin(), groups_.end(), [](const Group& group) { return !group.begun; });
  const auto chosen =
      fresh != groups_.end()
          ? fresh
          : std::max_element(groups_.begin(), groups_.end(),
                             [](const Group& a, const Group& b) { return a.left() < b.left(); });
  return static_cast<std::size_t>(chosen - groups_.begin());
}

void Runner::give_work(Slot& slot) {
  const auto work = take_job(slot);
  slot.state = work ? State::kRunning : State::kIdle;
  if (!work) return;
  slot.work = *work;
  slot.stage = TrialStage::kSetup;
  slot.started = Clock::now();
  slot.processor_time = slot.process.processor_time();
  // A worker that is gone shows in its replies.
  slot.process.send({WorkerOrder::Type::kTrial, "", "", options_.folder.string(), work->job.cell,
                     work->job.trial});
}

void Runner::finish(const Job& job, TrialRecord record, Clock::time_point started) {
  --unfinished_;
  const double wall_time = duration<double>(Clock::now() - started).count();
  const TrialKey key{experiment_.cells()[job.cell].key, job.trial};
  events_.trial_finished(key, {std::move(record), wall_time});
}

void Runner::handle_end(Slot& slot) {
  const State state = std::exchange(slot.state, State::kEnded);
  if (state == State::kEnded) return;
  const ProcessEnd end = slot.process.wait();
  if (state == State::kLoading && (!end.from_outside || ++load_deaths_ == kDeathsFromOutside)) {
    throw std::runtime_error(fmt::format("a worker ended while loading: {}", end.text));
  }
  if (state == State::kRunning) handle_death(slot, end);
}

void Runner::handle_death(const Slot& slot, const ProcessEnd& end) {
  const int deaths = slot.work.deaths + 1;
  if (deaths < (end.from_outside ? kDeathsFromOutside : kOwnDeaths)) {
    repeats_.push_back({slot.work.job, deaths});
    return;
  }
  finish(slot.work.job,
         {TrialOutcome::kCrashed, slot.stage, fmt::format("the process ended by {}", end.text), {}},
         slot.started);
}

void Runner::forgive_pause() {
  const Clock::time_point now = Clock::now();
  const auto pause = now - std::exchange(last_turn_, now);
  if (pause < kPause) return;
  for (const auto& slot : slots_) slot->started += pause;
}

void Runner::check_deadline(Slot& slot) {
  if (slot.state != State::kRunning && slot.state != State::kLoading) return;
  const double limit = experiment_.config().time_limit;
  const bool busy_for_too_long =
      slot.state == State::kRunning && slot.process.processor_time() - slot.processor_time > limit;
  if (!busy_for_too_long && Clock::now() < slot.started + patience_with(slot)) return;
  const State state = std::exchange(slot.state, State::kEnded);
  slot.process.kill();
  if (state == State::kLoading) {
    throw std::runtime_error(fmt::format("a worker did not load within {} s", kLoadLimit));
  }
  finish(slot.work.job,
         {TrialOutcome::kTimeout,
          slot.stage,
          fmt::format("no result within {} s of {} time",
                      number_text(busy_for_too_long ? limit : kPatience * limit),
                      busy_for_too_long ? "processor" : "wall-clock"),
          {}},
         slot.started);
}

}  // namespace binpick
