#include "experiments/sqlite_database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <utility>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr int kBusyTimeoutMs = 20'000;

}  // namespace

void SqliteDatabase::Close::operator()(sqlite3* database) const noexcept {
  sqlite3_close_v2(database);
}

void SqliteDatabase::Statement::Finalize::operator()(sqlite3_stmt* statement) const noexcept {
  sqlite3_finalize(statement);
}

SqliteDatabase::SqliteDatabase(std::filesystem::path file, Access access) : file_(std::move(file)) {
  // A reader asks for write access too: it may have to roll back what a killed writer left behind.
  // SQLite falls back to reading alone when the file is write-protected.
  const int flags = SQLITE_OPEN_READWRITE | (access == Access::kWrite ? SQLITE_OPEN_CREATE : 0);
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(file_.c_str(), &opened, flags, nullptr);
  database_.reset(opened);
  check(code);
  sqlite3_extended_result_codes(database_.get(), 1);
  sqlite3_busy_timeout(database_.get(), kBusyTimeoutMs);
  if (access == Access::kWrite) {
    // A rollback journal needs no shared memory and so works on a cluster's network file systems;
    // keeping the journal file saves two directory writes per commit.
    execute("PRAGMA journal_mode=PERSIST");
    execute("PRAGMA synchronous=FULL");
  }
}

void SqliteDatabase::execute(const std::string& sql) {
  check(sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr));
}

void SqliteDatabase::check(int code) const {
  if (code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE) return;
  const char* detail = database_ ? sqlite3_errmsg(database_.get()) : sqlite3_errstr(code);
  switch (code & 0xff) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:
    case SQLITE_MISMATCH:
      throw InputError(
          fmt::format("{}: not a usable result store ({}); move it away or give another "
                      "--out",
                      file_.string(), detail));
    case SQLITE_FULL:
      throw IoError(
          fmt::format("{}: no space left ({}); free some and run again, finished trials "
                      "are kept",
                      file_.string(), detail));
    default:
      throw IoError(fmt::format("{}: {}; check rights and free space", file_.string(), detail));
  }
}

SqliteDatabase::Statement::Statement(SqliteDatabase& database, std::string_view sql)
    : database_(database) {
  sqlite3_stmt* prepared = nullptr;
  database_.check(sqlite3_prepare_v2(database_.database_.get(), sql.data(),
                                     static_cast<int>(sql.size()), &prepared, nullptr));
  statement_.reset(prepared);
}

SqliteDatabase::Statement& SqliteDatabase::Statement::bind(int parameter, std::string_view text) {
  database_.check(sqlite3_bind_text(statement_.get(), parameter, text.data(),
                                    static_cast<int>(text.size()), SQLITE_TRANSIENT));
  return *this;
}

SqliteDatabase::Statement& SqliteDatabase::Statement::bind(int parameter, std::int64_t value) {
  database_.check(sqlite3_bind_int64(statement_.get(), parameter, value));
  return *this;
}

SqliteDatabase::Statement& SqliteDatabase::Statement::bind(int parameter, double value) {
  database_.check(sqlite3_bind_double(statement_.get(), parameter, value));
  return *this;
}

bool SqliteDatabase::Statement::step() {
  const int code = sqlite3_step(statement_.get());
  database_.check(code);
  return code == SQLITE_ROW;
}

std::string SqliteDatabase::Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  if (text == nullptr) return "";
  return {reinterpret_cast<const char*>(text),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::int64_t SqliteDatabase::Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double SqliteDatabase::Statement::number(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}

}  // namespace binpick
