#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace tumble::recorder {

/// Why SQLite does not do what it was asked for.
struct Refusal {
  int code = 0;  ///< of SQLite, without its extension
  std::string text;
  bool full() const;  ///< there is no room
  bool busy() const;  ///< another process has it
  bool no_database() const;
};

/// The only connection to a live store: it alone writes, checkpoints and locks. All functions throw Refusal.
class Database {
 public:
  enum class Mode { create, existing };
  Database(const std::string& path, const char* vfs, Mode mode);
  void run(const std::string& sql);
  /// Copies the write-ahead log back into the database.
  void checkpoint();
  sqlite3* get() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A statement, to be run again and again. Bound bytes must live until it was run.
class Statement {
 public:
  Statement(const Database& database, const std::string& sql);
  Statement& bind(int parameter, std::int64_t value);  ///< parameters from 1 on
  Statement& bind(int parameter, double value);        ///< any unit [u]
  Statement& bind_text(int parameter, std::string_view text);
  Statement& bind_bytes(int parameter, std::string_view bytes);
  bool next();                               ///< false after the last row, and the statement may be bound again
  std::int64_t integer(int column) const;    ///< columns from 0 on
  double number(int column) const;           ///< any unit, as the table has it [u]
  std::string_view bytes(int column) const;  ///< until next()

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace tumble::recorder
