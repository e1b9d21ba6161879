#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/result_folder.h"
#include "experiments/result_summary.h"

namespace binpick {

/// How far one store's part of a run is.
struct PartStatus {
  std::filesystem::path store;
  std::optional<Shard> shard;  ///< nothing for the store of a whole run
  std::int64_t done = 0;       ///< of its share, wherever it was done
  std::int64_t expected = 0;
  std::optional<StoreWriter> writer;  ///< who is at it now
  std::optional<double> time_left;    ///< s, of a part that is running and has finished some trial
};

/// How far a run is, and who is at work on it.
struct RunStatus {
  std::int64_t done = 0;
  std::int64_t expected = 0;
  bool complete = false;
  bool open_ended = false;  ///< a stopping rule may end it before `expected` trials
  std::vector<PartStatus> parts;
  std::vector<Shard> missing;  ///< shards that lack trials and have no store
  double work_time = 0.0;      ///< s, wall-clock time of all trials

  [[nodiscard]] bool running() const;
  /// "running", "complete" or "stopped".
  [[nodiscard]] std::string_view state() const;
  /// Until the last running part ends, s.
  [[nodiscard]] std::optional<double> time_left() const;
};

/// From the stores, their names and their locks. Time left is what is missing times the mean time
/// of a trial so far, by the number of workers.
[[nodiscard]] RunStatus run_status(const Experiment& experiment,
                                   const std::vector<std::filesystem::path>& stores,
                                   const RunResults& results, const ResultSummary& summary);

/// "shards 1, 4 of 8" for a person; empty when there are none.
[[nodiscard]] std::string missing_text(const std::vector<Shard>& missing);

}  // namespace binpick
