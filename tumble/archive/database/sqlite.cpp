#include "tumble/archive/database/sqlite.hpp"

#include <sqlite3.h>

#include <type_traits>

#include "tumble/formats/confinement.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::database {

namespace {

/// How long a writer waits for another one.
constexpr int patience_ms = 60'000;

Refusal refusal_of(const SqliteRefusal& refusal) {
  return {refusal.busy() ? Refusal::Kind::conflict : Refusal::Kind::failed, refusal.text};
}

void bind(SqliteStatement& statement, int parameter, const Value& value) {
  std::visit(
      [&](const auto& cell) {
        using Cell = std::decay_t<decltype(cell)>;
        if constexpr (std::is_same_v<Cell, std::monostate>)
          statement.bind_null(parameter);
        else if constexpr (std::is_same_v<Cell, std::string>)
          statement.bind_text(parameter, cell);
        else if constexpr (std::is_same_v<Cell, Bytes>)
          statement.bind_bytes(parameter, cell.data);
        else
          statement.bind(parameter, cell);
      },
      value);
}

Value cell_of(const SqliteStatement& statement, int column) {
  switch (statement.kind(column)) {
    case SqliteStatement::Kind::integer:
      return statement.integer(column);
    case SqliteStatement::Kind::number:
      return statement.number(column);
    case SqliteStatement::Kind::text:
      return std::string(statement.bytes(column));
    case SqliteStatement::Kind::bytes:
      return Bytes{std::string(statement.bytes(column))};
    case SqliteStatement::Kind::null:
      break;
  }
  return {};
}

void hand_out(SqliteStatement& statement, const RowSink& sink) {
  Row row(static_cast<std::size_t>(statement.columns()));
  while (statement.next()) {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = cell_of(statement, static_cast<int>(i));
    if (sink) sink(row);
  }
}

/// Gives up the remaining rows of a statement, however it ends.
struct ResetAtEnd {
  SqliteStatement& statement;
  ~ResetAtEnd() { statement.reset(); }
};

}  // namespace

/// Every commit is synchronised, and so is the removal of its journal. Several processes may write, one after the
/// other: with a write-ahead log, which is faster, SQLite up to 3.51.2 may damage a database then (docs/decisions/072).
/// Triggers make the tables append-only.
Sqlite::Sqlite(const std::string& path, bool create) {
  require_own_journals(path);
  try {
    sqlite3* handle = nullptr;
    const int mode = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (create ? SQLITE_OPEN_CREATE : 0);
    const int code = sqlite3_open_v2(path.c_str(), &handle, mode, nullptr);
    handle_.reset(handle);
    if (code != SQLITE_OK) refuse_sqlite(handle, code);
    sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 1, nullptr);
    sqlite3_busy_timeout(handle, patience_ms);
  } catch (const SqliteRefusal& refusal) {
    throw refusal_of(refusal);
  }
  script("PRAGMA journal_mode = DELETE; PRAGMA synchronous = EXTRA; PRAGMA cache_size = -65536");
}

void Sqlite::rows(const std::string& sql, const Row& values, const RowSink& sink) try {
  auto known = statements_.find(sql);
  if (known == statements_.end()) known = statements_.emplace(sql, SqliteStatement(handle_.get(), sql)).first;
  SqliteStatement& statement = known->second;
  const ResetAtEnd end{statement};
  for (std::size_t i = 0; i < values.size(); ++i) bind(statement, static_cast<int>(i) + 1, values[i]);
  hand_out(statement, sink);
} catch (const SqliteRefusal& refusal) {
  throw refusal_of(refusal);
}

void Sqlite::script(const std::string& sql) try {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) refuse_sqlite(handle_.get(), code);
} catch (const SqliteRefusal& refusal) {
  throw refusal_of(refusal);
}

std::int64_t Sqlite::changed() const { return sqlite3_changes64(handle_.get()); }

Problems Sqlite::damage() {
  Problems problems;
  rows("PRAGMA integrity_check", {}, [&](const Row& row) {
    if (text(row, 0) != "ok") problems.push_back(Sentence(text(row, 0).c_str()));
  });
  return problems;
}

}  // namespace tumble::database
