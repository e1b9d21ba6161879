#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/line_pipe.h"
#include "experiments/result_store.h"
#include "experiments/shard.h"

namespace binpick {

/// The results of one or more stores of the same run.
struct RunResults {
  RunManifest manifest;  ///< with the processors and hosts of all stores
  TrialTable trials;
  /// Keys under which the stores hold different records: a failure of reproducibility.
  std::vector<TrialKey> conflicts;

  /// @throws InputError when the trial was not run yet.
  [[nodiscard]] const StoredTrial& trial(const TrialKey& key) const;
};

/// Reads and joins stores, in any order with the same result.
/// @param extended the experiment that they are of, when some may still say what they were of
/// before its number of trials, stopping rule, gates or paper counts changed: the shards of a run
/// that is being extended, one after the other.
/// @throws InputError when there are none, or when they are not of one run and configuration.
[[nodiscard]] RunResults read_results(const std::vector<std::filesystem::path>& stores,
                                      const Experiment* extended = nullptr);

/// The run that is writing a store.
struct StoreWriter {
  std::string host;
  std::int64_t process = 0;
  int workers = 0;

  /// E.g. "process 4711 on node3".
  [[nodiscard]] std::string text() const;
};

/// A folder of results: `config.yaml`, `trials.sqlite` (of a shard, `trials-i-of-n.sqlite`), and
/// what is made of them: `trials.csv`, `trials.json`, `report.html`.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path path) : path_(std::move(path)) {}
  /// results/<experiment>-<hash of the effective configuration>, below the working folder.
  [[nodiscard]] static std::filesystem::path default_path(const Experiment& experiment);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// The stores that are here, sorted.
  [[nodiscard]] std::vector<std::filesystem::path> stores() const;
  [[nodiscard]] std::filesystem::path store_of(const std::optional<Shard>& shard) const;
  /// The inverse: which shard's a store is, by its name; nothing for the store of a whole run.
  [[nodiscard]] static std::optional<Shard> shard_of(const std::filesystem::path& store);
  /// @throws InputError unless there is at least one store.
  [[nodiscard]] RunResults read(const Experiment* extended = nullptr) const;

  /// Makes the folder and keeps other runs from writing this shard's store until the descriptor is
  /// closed or the process ends, however it ends. `workers` is for those who ask `writer_of`.
  /// @throws InputError when another run is at it, IoError when the folder cannot be written.
  [[nodiscard]] FileDescriptor lock(const std::optional<Shard>& shard, int workers) const;
  /// The run that is writing `store` now, if any. Asking does not disturb a run that starts.
  [[nodiscard]] static std::optional<StoreWriter> writer_of(const std::filesystem::path& store);
  /// Removes this shard's store, or without a shard all stores, and what was made of them.
  void clear(const std::optional<Shard>& shard) const;

 private:
  std::filesystem::path path_;
};

}  // namespace binpick
