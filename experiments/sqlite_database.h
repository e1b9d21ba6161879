#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace binpick {

/// An open SQLite file. Errors name the file: IoError for a full disk, missing rights and the like,
/// InputError for a file that is no database.
class SqliteDatabase {
 public:
  enum class Access { kRead, kWrite };

  /// With kWrite the file is made when it does not exist. Every commit reaches the disk before it
  /// returns.
  SqliteDatabase(std::filesystem::path file, Access access);

  void execute(const std::string& sql);

  /// A prepared statement; parameters count from 1, columns from 0.
  class Statement {
   public:
    Statement(SqliteDatabase& database, std::string_view sql);
    Statement& bind(int parameter, std::string_view text);
    Statement& bind(int parameter, std::int64_t value);
    Statement& bind(int parameter, double value);
    /// True while there is a row.
    bool step();
    [[nodiscard]] std::string text(int column) const;
    [[nodiscard]] std::int64_t integer(int column) const;
    [[nodiscard]] double number(int column) const;

   private:
    struct Finalize {
      void operator()(sqlite3_stmt* statement) const noexcept;
    };
    SqliteDatabase& database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  };

  [[nodiscard]] Statement prepare(std::string_view sql) { return {*this, sql}; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  struct Close {
    void operator()(sqlite3* database) const noexcept;
  };
  void check(int code) const;

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace binpick
