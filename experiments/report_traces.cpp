#include "experiments/report_traces.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "experiments/reproduce_line.h"
#include "experiments/write_file.h"

extern char** environ;

namespace binpick {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kSignature = "trial.json";
constexpr auto kPause = std::chrono::milliseconds(20);

/// Records of timed trials hold times, which are never the same again.
bool same_end(const TrialRecord& a, const TrialRecord& b) {
  return a.outcome == b.outcome && a.stage == b.stage && a.note == b.note;
}

bool is_trace_of(const std::filesystem::path& folder, const RunManifest& manifest,
                 const TrialRecord& stored) {
  std::ifstream file(folder / kSignature);
  const nlohmann::json signature = nlohmann::json::parse(file, nullptr, false);
  if (!signature.is_object()) return false;
  return signature.value("identity", "") == manifest.identity &&
         signature.value("inputs", "") == manifest.inputs &&
         same_end(record_from_json(signature.value("record", nlohmann::json()).dump()), stored);
}

std::vector<std::string> files_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename() != kSignature) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// `binpick reproduce` with a trace, at work.
class Reproduction {
 public:
  Reproduction(const std::filesystem::path& results, const TrialKey& key) : key_(key) {
    std::vector<std::string> words{"binpick",
                                   "reproduce",
                                   results,
                                   "--cell",
                                   key.cell,
                                   "--trial",
                                   fmt::format("{}", key.trial),
                                   "--trace",
                                   (results / trace_folder(key)).string()};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const int error =
        ::posix_spawn(&process_, "/proc/self/exe", &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) process_ = -1;
  }

  /// Whether it has ended; a process that needs more than `limit` is ended.
  [[nodiscard]] bool finished(Clock::duration limit) {
    if (process_ < 0) return true;
    if (Clock::now() - started_ > limit) ::kill(process_, SIGKILL);
    int status = 0;
    if (::waitpid(process_, &status, WNOHANG) == 0) return false;
    process_ = -1;
    return true;
  }

  [[nodiscard]] const TrialKey& key() const { return key_; }

 private:
  TrialKey key_;
  pid_t process_ = -1;
  Clock::time_point started_ = Clock::now();
};

}  // namespace

std::filesystem::path trace_folder(const TrialKey& key) {
  std::string cell = key.cell;
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '=' || c == ',' || c == '-' || c == '.';
  };
  std::replace_if(
      cell.begin(), cell.end(), [&](char c) { return !is_plain(static_cast<unsigned char>(c)); },
      '_');
  return std::filesystem::path("traces") / fmt::format("{}_{}", cell, key.trial);
}

void sign_trace(const std::filesystem::path& folder, const RunManifest& manifest,
                const TrialRecord& record) {
  const nlohmann::json signature{{"identity", manifest.identity},
                                 {"inputs", manifest.inputs},
                                 {"record", nlohmann::json::parse(to_json(record))}};
  make_folder(folder);
  write_file(folder / kSignature, signature.dump(1) + "\n");
}

std::vector<TrialTrace> find_traces(const std::filesystem::path& results_folder,
                                    const RunResults& results) {
  std::vector<TrialTrace> traces;
  if (!std::filesystem::is_directory(results_folder / "traces")) return traces;
  for (const auto& [key, trial] : results.trials) {
    const std::filesystem::path folder = trace_folder(key);
    if (!is_trace_of(results_folder / folder, results.manifest, trial.record)) continue;
    traces.push_back({key, folder, files_in(results_folder / folder)});
  }
  return traces;
}

std::vector<TrialKey> trials_to_trace(const Experiment& experiment, const TrialTable& trials,
                                      std::size_t most) {
  std::vector<TrialKey> failed;
  std::vector<TrialKey> others;
  for (std::int64_t i = 0; i < experiment.job_count(); ++i) {
    const Job job = experiment.job(i);
    const TrialKey key{experiment.cells()[job.cell].key, job.trial};
    const auto found = trials.find(key);
    if (found == trials.end()) continue;
    const TrialOutcome outcome = found->second.record.outcome;
    if (outcome == TrialOutcome::kCrashed) continue;
    (outcome == TrialOutcome::kSuccess ? others : failed).push_back(key);
  }
  failed.insert(failed.end(), others.begin(), others.end());
  failed.resize(std::min(failed.size(), most));
  return failed;
}

void make_traces(const ResultFolder& folder, const Experiment& experiment,
                 const RunResults& results, const std::vector<TrialKey>& trials) {
  std::vector<TrialKey> waiting;
  for (const TrialKey& key : trials) {
    const std::filesystem::path trace = folder.path() / trace_folder(key);
    if (!is_trace_of(trace, results.manifest, results.trials.at(key).record)) {
      waiting.push_back(key);
    }
  }
  if (waiting.empty()) return;
  fmt::print(stderr, "running {} trial{} again for pictures and replays\n", waiting.size(),
             waiting.size() == 1 ? "" : "s");
  std::reverse(waiting.begin(), waiting.end());
  // As generous as the runner's own limit by the clock.
  const auto limit = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(10.0 * experiment.config().time_limit));
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  std::vector<Reproduction> running;
  while (!waiting.empty() || !running.empty()) {
    while (!waiting.empty() && running.size() < cores) {
      // What an interrupted or an older trace has left must not mix with the new one.
      std::filesystem::remove_all(folder.path() / trace_folder(waiting.back()));
      running.emplace_back(folder.path(), waiting.back());
      waiting.pop_back();
    }
    std::this_thread::sleep_for(kPause);
    std::erase_if(running, [&](Reproduction& each) { return each.finished(limit); });
  }
  for (const TrialKey& key : trials) {
    const std::filesystem::path trace = folder.path() / trace_folder(key);
    if (is_trace_of(trace, results.manifest, results.trials.at(key).record)) continue;
    fmt::print(stderr, "not traced, or it ended otherwise than stored: {}\n",
               reproduce_line(folder.path().string(), key));
  }
}

}  // namespace binpick
