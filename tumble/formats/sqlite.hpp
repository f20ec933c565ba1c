#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace tumble {

/// Why SQLite does not do what it was asked for.
struct SqliteRefusal {
  int code = 0;  ///< of SQLite, without its extension
  std::string text;
  bool full() const;          ///< there is no room
  bool busy() const;          ///< another process has it
  bool input_output() const;  ///< the disk did not do what it was asked for
  bool no_database() const;
};

/// Throws SqliteRefusal with what the connection says; `handle` may be null.
[[noreturn]] void refuse_sqlite(sqlite3* handle, int code);

struct CloseSqlite {
  void operator()(sqlite3* handle) const;
};
using SqliteHandle = std::unique_ptr<sqlite3, CloseSqlite>;

/// A statement, to be run again and again. Bound bytes must live until it was run. All functions throw SqliteRefusal.
class SqliteStatement {
 public:
  SqliteStatement(sqlite3* database, const std::string& sql);
  SqliteStatement& bind(int parameter, std::int64_t value);  ///< parameters from 1 on
  SqliteStatement& bind(int parameter, double value);        ///< any unit [u]
  SqliteStatement& bind_text(int parameter, std::string_view text);
  SqliteStatement& bind_bytes(int parameter, std::string_view bytes);
  SqliteStatement& bind_null(int parameter);
  bool next();                               ///< false after the last row, and the statement may be bound again
  void reset();                              ///< gives up the remaining rows
  int columns() const;                       ///< number of columns of a row
  std::int64_t integer(int column) const;    ///< columns from 0 on
  double number(int column) const;           ///< any unit, as the table has it [u]
  std::string_view bytes(int column) const;  ///< until next()
  enum class Kind { integer, number, text, bytes, null };
  Kind kind(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace tumble
