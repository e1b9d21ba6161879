#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "experiments/run_manifest.h"
#include "experiments/sqlite_database.h"
#include "experiments/trial_record.h"

namespace binpick {

/// What identifies a trial within a run: cell key and trial number.
struct TrialKey {
  std::string cell;
  std::int64_t trial = 0;

  auto operator<=>(const TrialKey&) const = default;
};

struct StoredTrial {
  TrialRecord record;
  double wall_time = 0.0;  ///< s; not part of the record
};

/// Trials sorted by key.
using TrialTable = std::map<TrialKey, StoredTrial>;

/// Adds `trial` under `key`. The same record twice is one trial (its smaller wall time counts, so
/// that the order does not matter).
/// @return false when another record is there already: the runs were not reproducible.
[[nodiscard]] bool insert_trial(TrialTable& table, const TrialKey& key, const StoredTrial& trial);

/// One SQLite file of results: a manifest and one row per trial, each written in its own durable
/// transaction.
class ResultStore {
 public:
  /// Opens or makes the store for a run of `manifest`, which is brought up to date.
  /// @throws InputError when it holds results that cannot be mixed with this run, IoError when it
  /// cannot be written.
  [[nodiscard]] static ResultStore open_for_run(const std::filesystem::path& file,
                                                const RunManifest& manifest);
  /// @throws InputError when `file` is no result store.
  [[nodiscard]] static ResultStore open_to_read(const std::filesystem::path& file);

  [[nodiscard]] RunManifest manifest();
  [[nodiscard]] TrialTable trials();
  /// Writes one trial; it is on the disk when this returns. Writing the same key again is an error.
  /// @throws IoError when it cannot be written; earlier trials stay intact.
  void add(const TrialKey& key, const StoredTrial& trial);
  /// Writes many in one transaction.
  void add_all(const TrialTable& trials);

 private:
  explicit ResultStore(SqliteDatabase database) : database_(std::move(database)) {}
  void insert(const TrialKey& key, const StoredTrial& trial);

  SqliteDatabase database_;
};

}  // namespace binpick
