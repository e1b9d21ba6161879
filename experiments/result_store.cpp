#include "experiments/result_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr const char* kSchemaVersion = "1";

constexpr const char* kSchema = R"(
CREATE TABLE IF NOT EXISTS manifest (
  key TEXT PRIMARY KEY,
  value TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS trials (
  cell TEXT NOT NULL,
  trial INTEGER NOT NULL,
  outcome TEXT NOT NULL,
  stage TEXT NOT NULL,
  note TEXT NOT NULL,
  measures TEXT NOT NULL,
  wall_time_s REAL NOT NULL,
  PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
)";

std::map<std::string, std::string> read_entries(SqliteDatabase& database) {
  std::map<std::string, std::string> entries;
  auto rows = database.prepare("SELECT key, value FROM manifest");
  while (rows.step()) entries[rows.text(0)] = rows.text(1);
  return entries;
}

void check_schema(const SqliteDatabase& database,
                  const std::map<std::string, std::string>& entries) {
  const auto version = entries.find("schema");
  if (version == entries.end() || version->second != kSchemaVersion) {
    throw InputError(fmt::format("{}: a result store of schema '{}', this program reads '{}'",
                                 database.file().string(),
                                 version == entries.end() ? "" : version->second, kSchemaVersion));
  }
}

std::map<std::string, std::string> entries_of(const RunManifest& manifest) {
  auto entries = manifest.entries();
  entries.insert_or_assign("schema", std::string(kSchemaVersion));
  return entries;
}

void write_entries(SqliteDatabase& database, const RunManifest& manifest) {
  for (const auto& [key, value] : entries_of(manifest)) {
    auto row = database.prepare("INSERT OR REPLACE INTO manifest VALUES (?1, ?2)");
    row.bind(1, key).bind(2, value).step();
  }
}

/// Makes an empty store aside and puts it in place when it is whole: a run that is killed here
/// leaves no store rather than one without a manifest.
void make_store(const std::filesystem::path& file, const RunManifest& manifest) {
  const std::filesystem::path aside = file.string() + ".part";
  const std::filesystem::path journal = aside.string() + "-journal";
  std::error_code error;
  std::filesystem::remove(aside, error);
  std::filesystem::remove(journal, error);
  {
    SqliteDatabase database(aside, SqliteDatabase::Access::kWrite);
    database.execute("BEGIN IMMEDIATE");
    database.execute(kSchema);
    write_entries(database, manifest);
    database.execute("COMMIT");
  }
  std::filesystem::remove(journal, error);
  std::filesystem::rename(aside, file, error);
  if (error) {
    throw IoError(fmt::format("{}: cannot be made ({}); check rights and free space", file.string(),
                              error.message()));
  }
}

}  // namespace

bool insert_trial(TrialTable& table, const TrialKey& key, const StoredTrial& trial) {
  const auto [place, inserted] = table.emplace(key, trial);
  if (inserted) return true;
  if (!identical(place->second.record, trial.record)) return false;
  place->second.wall_time = std::min(place->second.wall_time, trial.wall_time);
  return true;
}

ResultStore ResultStore::open_for_run(const std::filesystem::path& file,
                                      const RunManifest& manifest) {
  if (!std::filesystem::exists(file)) make_store(file, manifest);
  SqliteDatabase database(file, SqliteDatabase::Access::kWrite);
  const auto stored = read_entries(database);
  check_schema(database, stored);
  const RunManifest earlier = RunManifest::from_entries(stored);
  const std::string conflict = manifest.conflict_with(earlier);
  if (!conflict.empty()) {
    throw InputError(fmt::format("{}: holds {}; give another --out, or --fresh to start over",
                                 file.string(), conflict));
  }
  RunManifest joined = manifest;
  joined.add_origins(earlier);
  if (entries_of(joined) != stored) {
    database.execute("BEGIN IMMEDIATE");
    write_entries(database, joined);
    database.execute("COMMIT");
  }
  return ResultStore(std::move(database));
}

ResultStore ResultStore::open_to_read(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) {
    throw InputError(fmt::format("{}: no result store here, check the path", file.string()));
  }
  SqliteDatabase database(file, SqliteDatabase::Access::kRead);
  check_schema(database, read_entries(database));
  return ResultStore(std::move(database));
}

RunManifest ResultStore::manifest() { return RunManifest::from_entries(read_entries(database_)); }

TrialTable ResultStore::trials() {
  TrialTable table;
  auto rows = database_.prepare(
      "SELECT cell, trial, outcome, stage, note, measures, wall_time_s FROM trials");
  while (rows.step()) {
    const auto outcome = outcome_from_text(rows.text(2));
    const auto stage = stage_from_text(rows.text(3));
    if (!outcome || !stage) {
      throw InputError(fmt::format("{}: trial {} of cell {} has an unknown outcome or stage",
                                   database_.file().string(), rows.integer(1), rows.text(0)));
    }
    table[{rows.text(0), rows.integer(1)}] = {
        {*outcome, *stage, rows.text(4), measures_from_json(rows.text(5))}, rows.number(6)};
  }
  return table;
}

void ResultStore::insert(const TrialKey& key, const StoredTrial& trial) {
  auto row = database_.prepare("INSERT INTO trials VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
  row.bind(1, key.cell)
      .bind(2, key.trial)
      .bind(3, to_text(trial.record.outcome))
      .bind(4, to_text(trial.record.stage))
      .bind(5, trial.record.note)
      .bind(6, measures_to_json(trial.record.measures))
      .bind(7, trial.wall_time)
      .step();
}

void ResultStore::add(const TrialKey& key, const StoredTrial& trial) { insert(key, trial); }

void ResultStore::add_all(const TrialTable& trials) {
  database_.execute("BEGIN IMMEDIATE");
  for (const auto& [key, trial] : trials) insert(key, trial);
  database_.execute("COMMIT");
}

}  // namespace binpick
