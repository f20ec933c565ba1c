#include "tumble/formats/sqlite.hpp"

#include <sqlite3.h>

namespace tumble {

bool SqliteRefusal::full() const { return code == SQLITE_FULL; }
bool SqliteRefusal::busy() const { return code == SQLITE_BUSY || code == SQLITE_LOCKED; }
bool SqliteRefusal::input_output() const { return code == SQLITE_IOERR; }
bool SqliteRefusal::no_database() const { return code == SQLITE_NOTADB || code == SQLITE_CORRUPT; }

void refuse_sqlite(sqlite3* handle, int code) {
  throw SqliteRefusal{code & 0xff, handle ? sqlite3_errmsg(handle) : sqlite3_errstr(code)};
}

void CloseSqlite::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

void SqliteStatement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

SqliteStatement::SqliteStatement(sqlite3* database, const std::string& sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database_, sql.c_str(), -1, &statement, nullptr);
  statement_.reset(statement);
  if (code != SQLITE_OK) refuse_sqlite(database_, code);
}

SqliteStatement& SqliteStatement::bind(int parameter, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), parameter, value);
  return *this;
}

SqliteStatement& SqliteStatement::bind(int parameter, double value) {
  sqlite3_bind_double(statement_.get(), parameter, value);
  return *this;
}

SqliteStatement& SqliteStatement::bind_text(int parameter, std::string_view text) {
  sqlite3_bind_text64(statement_.get(), parameter, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
  return *this;
}

SqliteStatement& SqliteStatement::bind_bytes(int parameter, std::string_view bytes) {
  sqlite3_bind_blob64(statement_.get(), parameter, bytes.data(), bytes.size(), SQLITE_STATIC);
  return *this;
}

SqliteStatement& SqliteStatement::bind_null(int parameter) {
  sqlite3_bind_null(statement_.get(), parameter);
  return *this;
}

bool SqliteStatement::next() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  const int reset = sqlite3_reset(statement_.get());
  if (code != SQLITE_DONE || reset != SQLITE_OK) refuse_sqlite(database_, code == SQLITE_DONE ? reset : code);
  return false;
}

void SqliteStatement::reset() { sqlite3_reset(statement_.get()); }
int SqliteStatement::columns() const { return sqlite3_column_count(statement_.get()); }
std::int64_t SqliteStatement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
double SqliteStatement::number(int column) const { return sqlite3_column_double(statement_.get(), column); }

std::string_view SqliteStatement::bytes(int column) const {
  const void* const data = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return data ? std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string_view();
}

SqliteStatement::Kind SqliteStatement::kind(int column) const {
  switch (sqlite3_column_type(statement_.get(), column)) {
    case SQLITE_INTEGER:
      return Kind::integer;
    case SQLITE_FLOAT:
      return Kind::number;
    case SQLITE_TEXT:
      return Kind::text;
    case SQLITE_BLOB:
      return Kind::bytes;
    default:
      return Kind::null;
  }
}

}  // namespace tumble
