#include "tumble/formats/rosbag2/database.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <filesystem>

#include "tumble/formats/confinement.hpp"
#include "tumble/formats/ros/message.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rosbag2 {
namespace {

[[noreturn]] void refuse(const Sentence& reason) { throw Error{Error::Kind::bad_file, reason}; }

/// A file that was cut off or damaged may claim anything: nothing of it is run, and no cell is larger than a message.
void be_careful(sqlite3* handle) {
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, 64 << 20);
}

/// A database that is written at this moment, or whose writer ended early, has a part of its rows in a file of its own.
void refuse_log_beside(const std::string& path) {
  for (const char* end : {"-wal", "-journal"}) {
    std::error_code absent;
    if (const auto size = std::filesystem::file_size(path + end, absent); absent || size == 0) continue;
    refuse(
        say("rows of it are in '{0}{1}', whose checksum no result would state: join them, sqlite3 '{0}' "
            "'pragma wal_checkpoint(truncate); vacuum', when the recorder has ended",
            path, end));
  }
}

/// Nothing is written beside the file, as SQLite else does.
std::string immutable(const std::string& path) {
  std::string name = path.starts_with('/') ? "file://" : "file:";
  for (const char letter : path)
    name += letter == '%' ? "%25" : letter == '?' ? "%3f" : letter == '#' ? "%23" : std::string(1, letter);
  return name + "?immutable=1";
}

}  // namespace

void Database::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

Database::Database(const std::string& path) {
  sqlite3* handle = nullptr;
  require_contained(path);
  refuse_log_beside(path);
  constexpr int how = SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_URI;
  const int code = sqlite3_open_v2(immutable(path).c_str(), &handle, how, nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) refuse(handle ? sqlite3_errmsg(handle) : "SQLite has no memory");
  be_careful(handle);
}

void Query::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Query::Query(const Database& database, const std::string& sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database.get(), sql.c_str(), -1, &statement, nullptr);
  statement_.reset(statement);
  if (code != SQLITE_OK) refuse(say("SQLite says: {}", sqlite3_errmsg(database.get())));
}

void Query::bind(int parameter, std::int64_t value) { sqlite3_bind_int64(statement_.get(), parameter, value); }

bool Query::next() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) refuse(say("SQLite says: {}", sqlite3_errmsg(database_.get())));
  return false;
}

std::int64_t Query::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

std::string_view Query::bytes(int column) const {
  const void* const data = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return data ? std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string_view();
}

bool Query::is_null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }

void require_tables(const Database& database) {
  Query query(database, "SELECT name, sql FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%'");
  std::string names;
  int needed = 0;
  while (query.next()) {
    const std::string name = ros::printable(query.bytes(0));
    const bool plain = query.bytes(1).starts_with("CREATE TABLE");
    needed += plain && (name == "topics" || name == "messages");
    if (names.size() < 200) names += (names.empty() ? "" : ", ") + name;
  }
  if (needed != 2)
    refuse(say("the tables 'topics' and 'messages' are not both there; its tables are {}",
               names.empty() ? Sentence("none") : say("{}", Name{names})));
}

}  // namespace tumble::rosbag2
